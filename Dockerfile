# Node, Foxglove bridge and recorder with ROS 2 Jazzy: docs/howto/container.md shows how to run them.
# The base is the official image, because the bridge and `ros2 bag` are packages for the Ubuntu release that it has.
FROM ros:jazzy-ros-base

# Versions are those of the ROS repository on the day of the build, as the base image's own.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install -y --no-install-recommends python3-dev python3-venv ros-jazzy-foxglove-bridge \
    && rm -rf /var/lib/apt/lists/*

RUN useradd --create-home --uid 10001 wheelset \
    && install --directory --owner wheelset --group wheelset /recordings /home/wheelset/.cache

WORKDIR /opt/wheelset_track_sim
COPY . .
SHELL ["/bin/bash", "-o", "pipefail", "-c"]
RUN source /opt/ros/jazzy/setup.bash \
    && python3 tools/setup_env.py prometheus \
    && rm -rf .venv/build "$HOME/.cache"

USER 10001
WORKDIR /recordings
ENV PATH=/opt/wheelset_track_sim/.venv/bin:/opt/wheelset_track_sim/.container:$PATH PYTHONUNBUFFERED=1
ENTRYPOINT ["with-ros"]
CMD ["wheelset-track-sim", "node", "--ros-args", "-p", "prometheus.port:=9464", "-p", "prometheus.address:=0.0.0.0"]
EXPOSE 9464
# The first start builds models and compiles kernels.
HEALTHCHECK --interval=10s --timeout=5s --start-period=300s CMD ["healthy"]
# The node closes its bag and ends with status 0, as with Ctrl-C.
STOPSIGNAL SIGINT
