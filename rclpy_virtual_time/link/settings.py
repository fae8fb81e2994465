"""Environment variables and libraries of hosts, for every launcher."""

from __future__ import annotations

import os

EPOCH = 1_700_000_000 * 10**9  # [ns] ROS time at the start of a test
NO_GPU = {"CUDA_VISIBLE_DEVICES": ""}  # the same run on every machine
LEARNING = {  # for programs that import Keras
    "KERAS_BACKEND": "torch",
    "KERAS_HOME": os.devnull,  # no settings read, none written
}
SAME_RUNS = {
    "LANG": "C.UTF-8",
    "PYTHONHASHSEED": "0",
    "PYTHONUNBUFFERED": "1",
    "OMP_NUM_THREADS": "1",  # one thread of numeric libraries: the same sums everywhere
    "OPENBLAS_NUM_THREADS": "1",
    "LOKY_MAX_CPU_COUNT": "1",  # scikit-learn's n_jobs=-1
    "RCUTILS_CONSOLE_OUTPUT_FORMAT": "[{severity}] [{name}]: {message}",
}

IN_BROWSER = "the browser: the page reaches nothing but itself"  # isolation
