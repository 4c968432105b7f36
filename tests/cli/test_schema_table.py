"""The table of keys in input/README.md is what `stylet schema --markdown` prints."""

import unittest

from stylet_cli import DONE, SOURCE, CliTest

START, END = "<!-- schema -->\n", "<!-- /schema -->"


class SchemaTable(CliTest):
    def test_table_of_keys(self):
        outcome = self.stylet("schema", "--markdown")
        self.assert_code(outcome, DONE)
        readme = (SOURCE / "input/README.md").read_text(encoding="utf-8")
        self.assertEqual(readme.count(START), 1)
        self.assertEqual(readme.count(END), 1)
        table = readme.split(START)[1].split(END)[0]
        self.assertEqual(table.strip(), outcome.out.strip(),
                         "renew it with jobs/schema_table.sh PROGRAM")

    def test_every_key_has_a_line_and_a_meaning(self):
        for line in self.stylet("schema", "--markdown").out.splitlines()[2:]:
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            self.assertEqual(len(cells), 4, line)
            self.assertTrue(all(cells), line)


if __name__ == "__main__":
    unittest.main()
