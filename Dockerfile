# gaitlab with both engines, for a container engine or, by way of it, for Apptainer on a cluster.
#   docker build -t gaitlab .
#   docker run --rm -v "$PWD:/work" -u "$(id -u):$(id -g)" gaitlab run eros_quick

FROM python:3.11-slim AS build
WORKDIR /source
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY gaitlab ./gaitlab
COPY surfaces ./surfaces
COPY motions ./motions
COPY experiments ./experiments
RUN python -m venv /opt/gaitlab \
 && /opt/gaitlab/bin/pip install --no-cache-dir -c constraints.txt hatchling \
 && /opt/gaitlab/bin/pip install --no-cache-dir -c constraints.txt --no-build-isolation \
      '.[cluster,mujoco,policy]'

FROM python:3.11-slim
COPY --from=build /opt/gaitlab /opt/gaitlab
ENV PATH=/opt/gaitlab/bin:$PATH
RUN useradd --create-home --uid 1000 walker
USER 1000:1000
# Results go to the folder `data` of what is mounted here. What is compiled goes to the home of
# whoever runs it or, where that cannot be written, to a folder of theirs in /tmp.
WORKDIR /work
ENTRYPOINT ["gaitlab"]
CMD ["--help"]
