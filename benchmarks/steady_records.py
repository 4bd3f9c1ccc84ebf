"""How many records are told not to be steady, of troughs that run steadily and of others.

Usage: python benchmarks/steady_records.py [--records 300]

Records are those of tests/helpers/unsteady_records.py, drawn without vibro: 8 to 300 cycles of 5 to 60 Hz
with 5 to 60 samples each. Steady ones have white or coloured noise, a ringing spring, jitter, a slow wander,
coarse digits, rows left out, harmonics or another machine. The others run up, stop, drift, beat, sweep,
pulse, step or slip, by 3 % to all of their amplitude, or up to ten turns. Of those that are accepted without
a word the last line says how many depart by more than 0.5 %, and by more than ten standard errors of the
mean (root mean square over the record).
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter, defaultdict
from pathlib import Path

from vibro.errors import InputError
from vibro.records.trough import motion_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from helpers.unsteady_records import Made, bad_record, good_record

OUTCOMES = ("refused", "part taken", "told", "accepted")


def outcome(made: Made) -> str:
    """Say what becomes of a record."""
    try:
        motion = motion_of(made.record)
    except InputError:
        return "refused"
    text = "".join(motion.warnings)
    return "part taken" if "the steady part" in text else "told" if "errors include" in text else "accepted"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--records", type=int, default=300)
    count = parser.parse_args().records
    for name, draw in (("steady", good_record), ("not steady", bad_record)):
        found: dict[str, Counter[str]] = defaultdict(Counter)
        hidden, largest = 0, 0.0
        for seed in range(count):
            made = draw(seed)
            what = outcome(made)
            found[made.kind][what] += 1
            if what == "accepted" and name == "not steady":
                hidden += made.clear > 10.0
                largest = max(largest, made.change)
        print(f"{name:16}" + "".join(f"{one:>12}" for one in OUTCOMES))
        for kind, counts in found.items():
            print(f"{kind:16}" + "".join(f"{counts[one]:12}" for one in OUTCOMES))
        total = sum(found.values(), Counter())
        print(f"{'all':16}" + "".join(f"{total[one]:12}" for one in OUTCOMES))
        if name == "not steady":
            print(f"accepted: the largest change is {largest:.2f}, {hidden} of them are clear of the noise")


if __name__ == "__main__":
    main()
