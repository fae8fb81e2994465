# One image for GitHub Codespaces, Binder and a JupyterHub: Jupyter with the course in it.
# Never built by us: there was no Docker. Its steps were run, in order, in a bare Debian.
FROM python:3.12-slim-bookworm

# Binder builds with these two, and mounts nothing; a hub may mount a volume over the home
ARG NB_USER=jovyan
ARG NB_UID=1000
ENV USER=${NB_USER} NB_UID=${NB_UID} HOME=/home/${NB_USER}
ENV PATH=/opt/course/venv/bin:${PATH} PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1

RUN apt-get update \
    && apt-get install -y --no-install-recommends adduser git \
    && rm -rf /var/lib/apt/lists/* \
    && adduser --disabled-password --gecos "" --uid ${NB_UID} ${NB_USER} \
    && mkdir /opt/course \
    && chown ${NB_UID} /opt/course

# The course lies outside of the home; what is in the home is the student's copy to work in
COPY --chown=${NB_UID} . /opt/course/source
COPY --chown=${NB_UID} . ${HOME}
USER ${NB_USER}
WORKDIR /opt/course/source
RUN python3 -m venv /opt/course/venv \
    && pip install --constraint constraints.txt --editable '.[ros,ml,notebooks]' \
        'jupyterhub>=5,<6' 'notebook>=7,<8'

# A release has its notebooks. Those of a checkout are made here, with skeletons: .dockerignore
WORKDIR ${HOME}
RUN test ! -d notebooks/text || python -m grader.notebook.build
EXPOSE 8888
CMD ["jupyter", "lab", "--ip=0.0.0.0", "--no-browser"]
