"""A fleet on Slurm by dask-jobqueue: `python slurm.py DATA fleet.parquet`, installed where every node sees it."""

import sys

from dask_jobqueue import SLURMCluster
from distributed import Client

import er_model_lab as lab

JOBS = 100
"""Jobs of one core each; a job that ends at its limit of time is started again."""


def cluster() -> SLURMCluster:
    """The cluster; queue and account are those of your Slurm."""
    return SLURMCluster(
        cores=1, processes=1, memory="2GiB", walltime="04:00:00",
        job_script_prologue=["export NUMBA_NUM_THREADS=1"],
        worker_extra_args=["--lifetime", "225m", "--lifetime-stagger", "10m"],
        scheduler_options={"dashboard": False},
    )  # fmt: skip


def main() -> None:
    """Start the jobs, work, and end them."""
    data, out = sys.argv[1:]
    with cluster() as jobs, Client(jobs) as client:
        jobs.adapt(minimum_jobs=1, maximum_jobs=JOBS)
        client.wait_for_workers(1)  # however long the queue is
        model = lab.load_model("inove_guo")
        lab.fleet(data, model, out=out, cluster=jobs.scheduler_address, resume=True)


if __name__ == "__main__":
    main()
