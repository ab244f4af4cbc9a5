# SPDX-License-Identifier: Apache-2.0
"""Overlapping Allan deviation as numpy users write it, timed: the peer of signal_allan_bench.cpp.

Usage: signal_allan_peer.py SAMPLES MULTIPLE...
Prints a line for each multiple: the least of three times in seconds, that of the processor alone (other programs may
hold it meanwhile), and the deviation of white noise times the root of the multiple, which is near 1.
"""
import sys
import time

import numpy


def overlapping_allan_deviation(phase, m):
    difference = phase[2 * m:] - 2.0 * phase[m:-m] + phase[:-2 * m]
    return numpy.sqrt(0.5 * numpy.sum(difference**2) / difference.size) / m


def least_times(phase, m):
    wall, processor = [], []
    for _ in range(3):
        start, start_processor = time.perf_counter(), time.process_time()
        deviation = overlapping_allan_deviation(phase, m)
        wall.append(time.perf_counter() - start)
        processor.append(time.process_time() - start_processor)
    return min(wall), min(processor), deviation


def main():
    samples, multiples = int(sys.argv[1]), [int(m) for m in sys.argv[2:]]
    rate = numpy.random.default_rng(1).standard_normal(samples)
    phase = numpy.concatenate([[0.0], numpy.cumsum(rate)])
    for m in multiples:
        wall, processor, deviation = least_times(phase, m)
        print(wall, processor, deviation * m**0.5)


main()
