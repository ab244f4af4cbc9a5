#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The blind benchmark of the gap workflow: how often `soak gap find` is right, with exact binomial intervals.

Campaigns are made up by soaksim-campaign (hal/sim, which shares nothing with calib but its vocabulary), reach soak as
CSV through `soak import`, and the truth stays with this program. Each campaign is a line of the output file as soon as
it is judged; tables are printed from that file, also from one that is not complete.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import signal
import sys
import time

# One thread per process: numpy's own would compete with --jobs.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from blind_campaign import Programs  # noqa: E402
from campaign_record import judged  # noqa: E402
from cells import Counts, plan  # noqa: E402
from tables import print_tables  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]


def parse_options():
    parser = argparse.ArgumentParser(prog="./run bench gap", description=__doc__.split("\n")[0])
    parser.add_argument("--bin", default=str(ROOT / "build" / "release" / "bin"), help="folder of the programs")
    parser.add_argument("--first", type=int, default=100000, metavar="SEED", help="first seed (%(default)s)")
    parser.add_argument("--nulls", type=int, default=500, help="campaigns without effect, per design (%(default)s)")
    parser.add_argument("--seeds", type=int, default=20, help="campaigns per effect and magnitude (%(default)s)")
    parser.add_argument("--stress-seeds", type=int, default=5, help="the same in the stress designs (%(default)s)")
    parser.add_argument("--pair-seeds", type=int, default=2, help="campaigns per pair and design (%(default)s)")
    parser.add_argument("--unknown-seeds", type=int, default=20, help="campaigns per unknown effect and magnitude (%(default)s)")
    parser.add_argument("--magnitudes", type=float, nargs="+", default=[0.3, 0.6, 1.2],
                        help="RMS over the repeatability of a block (%(default)s)")
    parser.add_argument("--pair-magnitude", type=float, default=0.6, help="of both (%(default)s)")
    parser.add_argument("--cells", metavar="REGEX", default="",
                        help="only cells whose name has it; seeds are those of the whole plan")
    parser.add_argument("--list", action="store_true", help="print the cells and how many campaigns each has; do nothing")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="campaigns at once (%(default)s here)")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "build" / "bench-gap.jsonl", metavar="FILE",
                        help="the verdicts, a line of JSON per campaign (build/bench-gap.jsonl)")
    parser.add_argument("--resume", action="store_true", help="leave out what FILE has already")
    parser.add_argument("--tables", type=pathlib.Path, metavar="FILE", help="print the tables of FILE; run nothing")
    return parser.parse_args()


def planned(options):
    counts = Counts(options.nulls, options.seeds, options.stress_seeds, options.pair_seeds, options.unknown_seeds,
                    tuple(options.magnitudes), options.pair_magnitude)
    return [(cell, seed) for cell, seed in plan(counts, options.first) if re.search(options.cells, cell.name())]


def read_records(path):
    """The last record of every campaign; a line that a stopped run left incomplete is passed over."""
    records = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        records[(record["cell"], record["seed"])] = record
    return list(records.values())


def end_line(path, file):
    """So that a line which a stopped run left incomplete stays alone."""
    text = path.read_bytes()
    if text and not text.endswith(b"\n"):
        file.write("\n")


def judge_one(bin_folder, cell, seed):
    return judged(Programs(bin_folder, ROOT / "hal" / "sim" / "lab.toml"), cell, seed)


def leave_interrupts():
    """To the parent: a worker brings its campaign to an end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def run(campaigns, options):
    """Judges all, each record appended to the file at once. Ctrl-C and SIGTERM let the campaigns at work come to an end."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    start_s = time.monotonic()
    options.output.parent.mkdir(parents=True, exist_ok=True)
    workers = concurrent.futures.ProcessPoolExecutor(options.jobs, initializer=leave_interrupts)
    with workers as pool, open(options.output, "a", encoding="utf-8") as file:
        end_line(options.output, file)
        futures = [pool.submit(judge_one, options.bin, cell, seed) for cell, seed in campaigns]
        try:
            for done, future in enumerate(concurrent.futures.as_completed(futures), 1):
                file.write(json.dumps(future.result()) + "\n")
                file.flush()
                if sys.stderr.isatty():
                    left_s = (time.monotonic() - start_s) / done * (len(futures) - done)
                    print(f"\r{done} of {len(futures)} campaigns, {left_s / 60:.0f} min left ", end="", file=sys.stderr)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def main():
    options = parse_options()
    if options.tables:
        print_tables(read_records(options.tables))
        return
    campaigns = planned(options)
    if options.list:
        for cell in dict.fromkeys(cell for cell, _ in campaigns):
            print(f"{cell.count:5}  {cell.name()}")
        return
    if options.output.exists():
        if not options.resume:
            sys.exit(f"{options.output} exists: --resume goes on with it, -o writes another file")
        done = {(record["cell"], record["seed"]) for record in read_records(options.output) if "error" not in record}
        campaigns = [(cell, seed) for cell, seed in campaigns if (cell.name(), seed) not in done]
    try:
        run(campaigns, options)
    except KeyboardInterrupt:
        sys.exit(f"stopped; {options.output} holds what was judged, --resume goes on with it")
    print_tables(read_records(options.output))


if __name__ == "__main__":
    main()
