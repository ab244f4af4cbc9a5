#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times PyWavelets with numpy on the task of signal_wavelet_bench.cpp: decompose (db8, level 6, symmetric), soft
threshold on all details, reconstruct. Prints the least processor time in milliseconds.

  signal_wavelet_peer.py SAMPLES REPETITIONS
"""
import sys
import time

import numpy
import pywt


def denoise(signal):
    approximation, *details = pywt.wavedec(signal, "db8", "symmetric", level=6)
    shrunk = [pywt.threshold(d, 0.5, "soft") for d in details]
    return pywt.waverec([approximation, *shrunk], "db8", "symmetric")


def seconds(signal):
    start = time.process_time()
    denoise(signal)
    return time.process_time() - start


def main():
    samples, repetitions = int(sys.argv[1]), int(sys.argv[2])
    signal = numpy.random.default_rng(1).standard_normal(samples)
    print(1e3 * min(seconds(signal) for _ in range(repetitions)))


if __name__ == "__main__":
    main()
