"""Linear algebra on one thread: matrices are small here, and threads that wait for more take cores from the kernel."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

Asked = ParamSpec("Asked")
Answer = TypeVar("Answer")


def on_one_thread(work: Callable[Asked, Answer]) -> Callable[Asked, Answer]:
    """The same work with the linear algebra of the whole process on one thread meanwhile."""

    @wraps(work)
    def limited(*args: Asked.args, **options: Asked.kwargs) -> Answer:
        with threadpool_limits(1, "blas"):
            return work(*args, **options)

    return limited
