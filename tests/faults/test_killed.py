"""Runs that are killed, at any moment: what they leave can be read, and they go on as if nothing had
happened. With --moments N as many as that, and a table of what became of them."""

import collections
import os
import random
import shutil
import signal
import sys
import time
import unittest

from compare import differences
from scenes import PATIENCE, SHORT, FaultTest, faults, ranks_of

MOMENTS = 3
OUTCOMES = collections.Counter()


def became(said):
    for words, what in (("going on at", "goes on"), ("begins at its beginning", "begins"),
                        ("completed already", "was complete")):
        if words in said:
            return what + (", one not whole" if "is not whole" in said else "")
    return "begins"


class Killed(FaultTest):
    def setUp(self):
        super().setUp()
        self.random = random.Random(7)

    def check(self, n, name, how):
        self.assert_readable(name)
        OUTCOMES[n, how, became(self.assert_goes_on(n, name))] += 1
        shutil.rmtree(self.folder / name)

    def assert_died(self, outcome):
        """Or was done before: a history is handed over by the clock, so the calls vary by some."""
        self.assertIn(outcome.code, (-signal.SIGKILL, 0), str(outcome))

    def test_between_any_two_changes_of_files(self):
        """What a machine that goes down leaves is what the calls so far have left, the last in part."""
        count = self.folder / "count"
        self.run_short(1, "counted", "--quiet", faulty=faults(on="/counted/", count=count))
        n_calls = int(count.read_text())
        for i in range(MOMENTS):
            at = self.random.randint(1, n_calls)
            with self.subTest(call=at, of=n_calls):
                dead = self.run_short(1, "part", "--quiet", faulty=faults(on="/part/", kill=at))
                self.assert_died(dead)
                self.check(1, "part", "between two calls")

    def test_while_it_goes_on(self):
        """Killed when it was begun, and again when it went on."""
        count = self.folder / "count"
        self.run_short(1, "kept", "--until", "0.6 s")
        # With a checkpoint more than the whole run has, which is round-off.
        unkilled = shutil.copytree(self.folder / "kept", self.folder / "unkilled")
        self.run_short(1, "unkilled", "--resume", faulty=faults(on="/unkilled/", count=count))
        n_calls = int(count.read_text())
        for i in range(MOMENTS):
            at = self.random.randint(1, n_calls)
            with self.subTest(call=at, of=n_calls):
                part = shutil.copytree(self.folder / "kept", self.folder / "part")
                dead = self.run_short(1, "part", "--resume", faulty=faults(on="/part/", kill=at))
                self.assert_died(dead)
                self.assert_readable("part")
                outcome = self.run_short(1, "part", "--resume")
                self.assert_code(outcome, 0)
                self.assertEqual(differences(unkilled, part), [])
                OUTCOMES[1, "while it goes on", became(outcome.out)] += 1
                shutil.rmtree(part)

    def test_at_any_time(self):
        for n in (1, 2):
            self.whole(n)
            timed = self.run_short(n, "timed", "--quiet")
            shutil.rmtree(self.folder / "timed")
            for i in range(max(1, MOMENTS // (3 * n - 2))):
                with self.subTest(ranks=n, i=i):
                    program = self.start(n, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT)
                    time.sleep(self.random.uniform(0, timed.seconds))
                    self.kill(program)
                    if (self.folder / "part").exists():
                        self.check(n, "part", "all ranks at once")

    def test_while_a_checkpoint_is_written(self):
        for i in range(MOMENTS):
            program = self.start(1, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT,
                                 faulty=faults(on="checkpoints/", slow=4000))
            folder = self.folder / "part/checkpoints"
            wanted = self.random.randint(1, 5)  # of seven
            seen = set()

            def is_begun():
                seen.update(folder.glob(".stylet.*.tmp"))
                return len(seen) >= wanted

            self.assertTrue(self.wait_for(program, is_begun))
            time.sleep(self.random.uniform(0, 0.1))
            self.kill(program)
            self.check(1, "part", "while a checkpoint is written")
            self.assertFalse(folder.exists())

    def test_one_rank(self):
        self.whole(2)
        for first in (True, False):
            with self.subTest(first_rank=first):
                program = self.start(2, "run", "scene.yaml", "--quiet", "--output", "part", *SHORT)
                checkpoint = self.folder / "part/checkpoints/00000014.h5"
                self.assertTrue(self.wait_for(program, checkpoint.exists))
                writer = int((self.folder / "part/.stylet.lock").read_text().split()[0])
                ranks = ranks_of(program.pid)
                os.kill(next(pid for pid in ranks if (pid == writer) == first), signal.SIGKILL)
                start = time.monotonic()
                program.communicate(timeout=PATIENCE)
                print(f"rank {'0' if first else '1'} killed: {time.monotonic() - start:.1f} s")
                self.assertNotEqual(program.returncode, 0)
                status, error = self.status("part")
                self.assertEqual(status, "failed" if first else "stopped")
                self.assertIn("rank 0 has died" if first else "signal TERM", error)
                self.check(2, "part", "one rank")


if __name__ == "__main__":
    if "--moments" in sys.argv:
        at = sys.argv.index("--moments")
        MOMENTS = int(sys.argv[at + 1])
        del sys.argv[at:at + 2]
    result = unittest.main(exit=False).result
    for (n, how, what), times in sorted(OUTCOMES.items()):
        print(f"{n} rank{'s' if n > 1 else ''}, killed {how}: {what}: {times}")
    sys.exit(not result.wasSuccessful())
