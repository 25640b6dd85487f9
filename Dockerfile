# ROS 2 Jazzy from apt with what ./er asks for. docker build -t er-damper . && docker run --rm er-damper
# The stage base has the tools alone: for the development container and for tests of a checkout that is mounted.
FROM ros:jazzy AS base
RUN apt-get update \
    && apt-get install --yes --no-install-recommends g++ git python3-dev python3-venv \
       ros-jazzy-rosbag2-storage-mcap \
    && rm -rf /var/lib/apt/lists/*

FROM base AS product
COPY --chown=ubuntu . /home/ubuntu/er-damper
USER ubuntu
WORKDIR /home/ubuntu/er-damper
RUN ./er setup --compile
ENTRYPOINT ["./er"]
CMD ["demo"]
