# SPDX-License-Identifier: Apache-2.0
"""The benchmark's tables, from its records. docs/gap-workflow.md says how to read them."""
import collections
import statistics

from cells import DESIGNS, EFFECTS, KIN, NEED_LOGS, OTHERS, PAIR_DESIGNS, STRESS, UNKNOWN
from intervals import share
from oracle import names_beyond

STAGES = ("generate", "import", "fit", "find", "judge")


def chosen(records, **wanted):
    return [record for record in records if all(record[key] == value for key, value in wanted.items())]


def values_of(records, key):
    return sorted({record[key] for record in records})


def counted(records, test):
    return sum(bool(test(record)) for record in records)


def first_right(record):
    return record["names"][:1] == record["effects"][:1]


def exactly_right(record):
    return sorted(record["names"]) == sorted(record["effects"])


def thresholds(records):
    """By design: what the oracle's ratio must exceed for it to be wrong on as many nulls as ours is."""
    found = {}
    for design in DESIGNS:
        nulls = chosen(records, table="null", design=design)
        ratios = sorted((record["oracle"][0]["ratio"] for record in nulls), reverse=True)
        false_names = counted(nulls, lambda record: record["names"])
        if false_names < len(ratios):
            found[design] = ratios[false_names]
    return found


def oracle_right(record, limits):
    limit = limits.get(record["design"])
    found = names_beyond(record["oracle"], limit, len(record["effects"])) if limit is not None else []
    return sorted(found) == sorted(record["effects"])


def of_oracle(records, limits, right):
    """The oracle's rate and ours over it, as texts."""
    judged = [record for record in records if record["design"] in limits]
    if not judged:
        return "-", "-"
    oracle = counted(judged, lambda record: oracle_right(record, limits))
    return f"{oracle}/{len(judged)}", f"{counted(judged, right) / oracle:.2f}" if oracle else "-"


def print_row(*texts, widths):
    print("  " + " ".join(f"{text:{width}}" for text, width in zip(texts, widths)).rstrip())


def print_nulls(records, limits):
    widths = (16, 27, 10, 28, 10)
    print("\nNothing hidden")
    print_row("design", "false names, ours", "unknown", "false names, quick", "oracle's threshold", widths=widths)
    for design in DESIGNS:
        found = chosen(records, table="null", design=design)
        if found:
            print_row(design, share(counted(found, lambda r: r["names"]), len(found)),
                      str(counted(found, lambda r: r["verdict"] == "unknown")),
                      share(counted(found, lambda r: r["naive"]["name"]), len(found)),
                      f"{limits[design]:.1f}" if design in limits else "-", widths=widths)
    false = collections.Counter("+".join(r["names"]) for r in chosen(records, table="null") if r["names"])
    for name, count in false.most_common():
        print(f"  false: {count} x {name}")


def print_named(records, limits):
    widths = (16, 5, 28, 8, 7, 30, 7, 10)
    print("\nOne effect hidden, all effects that can be seen within a run")
    print_row("design", "size", "named first, ours", "oracle", "ratio", "right when ours names", "a 2nd", "quick: right/named",
              widths=widths)
    for design in DESIGNS:
        for magnitude in values_of(chosen(records, table="named", design=design), "magnitude"):
            found = chosen(records, table="named", design=design, magnitude=magnitude)
            named = [record for record in found if record["names"]]
            quick = [record for record in found if record["naive"]["name"]]
            print_row(design, f"{magnitude:g}", share(counted(found, first_right), len(found)),
                      *of_oracle(found, limits, first_right), share(counted(named, first_right), len(named)),
                      str(counted(found, lambda r: len(r["names"]) > 1)),
                      f"{counted(quick, lambda r: [r['naive']['name']] == r['effects'])}/{len(quick)}", widths=widths)


def said(records):
    """What was said instead of the right name, most often first."""
    texts = collections.Counter(("+".join(r["names"]) or r["verdict"]) for r in records if not first_right(r))
    return ", ".join(f"{count} {text}" for text, count in texts.most_common(4))


def print_effects(records, limits, table, names):
    found = chosen(records, table=table)
    if not found:
        return
    widths = (24, 5, 9, 9, 7, 10)
    print("\nBy effect, all designs" if table == "named" else "\nOther names, identical runs")
    print_row("effect", "size", "ours", "oracle", "ratio", "instead", widths=widths)
    for name in names:
        for magnitude in values_of(found, "magnitude"):
            cell = chosen(found, effects=[name], magnitude=magnitude)
            if not cell:
                continue
            beside = of_oracle(cell, limits, first_right) if table == "named" else ("-", "-")
            print_row(name, f"{magnitude:g}", f"{counted(cell, first_right)}/{len(cell)}", *beside, said(cell), widths=widths)


def pair_kind(record):
    if exactly_right(record):
        return "both"
    if set(record["names"]) - set(record["effects"]):
        return "false"
    return "one" if record["names"] else record["verdict"]


def print_pairs(records, limits):
    widths = (16, 5, 28, 8, 7, 9, 9, 9, 9)
    found = chosen(records, table="pair")
    if not found:
        return
    print("\nTwo effects hidden: all pairs")
    print_row("design", "size", "both exactly, ours", "oracle", "ratio", "one", "false", "none", "unknown", widths=widths)
    for design in PAIR_DESIGNS:
        for magnitude in values_of(chosen(found, design=design), "magnitude"):
            cell = chosen(found, design=design, magnitude=magnitude)
            kinds = collections.Counter(pair_kind(record) for record in cell)
            print_row(design, f"{magnitude:g}", share(kinds["both"], len(cell)), *of_oracle(cell, limits, exactly_right),
                      *(str(kinds[kind]) for kind in ("one", "false", "none", "unknown")), widths=widths)
    print("  by member: both exactly of pairs with it; false names in pairs")
    for name in EFFECTS:
        cell = [record for record in found if name in record["effects"]]
        beside = of_oracle(cell, limits, exactly_right)[0]
        print(f"    {name:24} {counted(cell, exactly_right)}/{len(cell)}, oracle {beside:8}"
              f" false {counted(found, lambda r, name=name: name in r['names'] and name not in r['effects'])}")


def of_kin(record):
    """Whether the one name, or a set of three at most that it stands for, holds what the library has of that kind."""
    held = record.get("set") or record["names"]
    return len(record["names"]) == 1 and len(held) <= 3 and KIN.get(record["effects"][0]) in held


def print_unknown(records):
    found = chosen(records, table="unknown")
    if not found:
        return
    widths = (18, 5, 30, 9, 7, 6, 10)
    print("\nMechanisms that are not the library's; kin: one name, what the library has of that kind or not told from it")
    print_row("effect", "size", "unknown or kin", "unknown", "kin", "none", "false names", widths=widths)
    for name in UNKNOWN:
        for magnitude in values_of(found, "magnitude"):
            cell = chosen(found, effects=[name], magnitude=magnitude)
            kinds = collections.Counter(record["verdict"] for record in cell)
            kin = counted(cell, of_kin)
            names = collections.Counter("+".join(r["names"]) for r in cell if r["names"] and not of_kin(r)).most_common(3)
            if cell:
                print_row(name, f"{magnitude:g}", share(kinds["unknown"] + kin, len(cell)), str(kinds["unknown"]), str(kin), str(kinds["none"]),
                          ", ".join(f"{count} {text}" for text, count in names), widths=widths)


def print_unlogged(records):
    found = chosen(records, table="unlogged")
    if not found:
        return
    widths = (24, 5, 28, 10, 10)
    print("\nEffects of which nothing was logged that could tell them")
    print_row("effect", "size", "another name", "unknown", "none", widths=widths)
    for name in NEED_LOGS:
        for magnitude in values_of(found, "magnitude"):
            cell = chosen(found, effects=[name], magnitude=magnitude)
            kinds = collections.Counter(record["verdict"] for record in cell)
            if cell:
                print_row(name, f"{magnitude:g}", share(kinds["named"], len(cell)), str(kinds["unknown"]), str(kinds["none"]),
                          widths=widths)


def print_one(records):
    found = chosen(records, table="one")
    if found:
        print(f"\nOne run: cannot_judge {share(counted(found, lambda r: r['verdict'] == 'cannot_judge'), len(found))}")


def print_closed(records):
    print("\nClosed fraction on held-out runs where the name is right: median over campaigns and sensors")
    for magnitude in values_of(chosen(records, table="named"), "magnitude"):
        right = [record for record in chosen(records, table="named", magnitude=magnitude) if first_right(record)]
        values = [value for record in right for value in record["closed"].values()]
        told = [value for value in values if value is not None]
        if values:
            median = f"{statistics.median(told):.2f}" if told else "-"
            print(f"  {magnitude:g}: {median} of {len(told)}; too small to tell {len(values) - len(told)}")


def print_costs(records, failed):
    seeds = [record["seed"] for record in records + failed]
    print(f"{len(records)} campaigns, seeds {min(seeds)} to {max(seeds)}; {len(failed)} more failed")
    for record in failed:
        print(f"  {record['cell']} seed {record['seed']}: {record['error'].strip().splitlines()[-1]}")
    stages = {stage: statistics.mean(r["cpu_s"].get(stage, 0.0) for r in records) for stage in STAGES}
    print("CPU per campaign: " + ", ".join(f"{stage} {cpu_s:.2f} s" for stage, cpu_s in stages.items()))


def print_summary(records, limits):
    """One row per kind of design, beside what is asked for."""
    widths = (16, 30, 29, 14, 14)
    print("\nIn short")
    print_row("design", "right when it names one", "named first, from 0.6 up", "0.3 / oracle", "pairs / oracle", widths=widths)
    for title, designs in (*((name, (name,)) for name in DESIGNS if name not in STRESS), ("stress, all five", STRESS)):
        here = [record for record in records if record["design"] in designs]
        single, pairs = chosen(here, table="named"), chosen(here, table="pair")
        named = [record for record in single if record["names"]]
        large = [record for record in single if record["magnitude"] >= 0.6]
        small = of_oracle([record for record in single if record["magnitude"] == 0.3], limits, first_right)[1]
        if single or pairs:
            print_row(title, share(counted(named, first_right), len(named)), share(counted(large, first_right), len(large)),
                      small, of_oracle(pairs, limits, exactly_right)[1], widths=widths)
    print("  asked: 98 %; 97 %, under stress 90 %; 0.90; 0.90. False names: upper bound 2 %. Unknown effects: 95 %.")


def print_tables(everything):
    records = [record for record in everything if "error" not in record]
    if not records:
        print("no campaign has been judged")
        return
    limits = thresholds(records)
    print_costs(records, [record for record in everything if "error" in record])
    print_nulls(records, limits)
    print_named(records, limits)
    print_effects(records, limits, "named", EFFECTS)
    print_effects(records, limits, "other", OTHERS)
    print_pairs(records, limits)
    print_unknown(records)
    print_unlogged(records)
    print_one(records)
    print_closed(records)
    print_summary(records, limits)
