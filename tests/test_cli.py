"""The command line from outside: exit statuses, output, and that nothing is lost."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from metrology.cli import main

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "tests" / "reference" / "gum-h1-end-gauge"


@pytest.fixture
def campaign(tmp_path):
    shutil.copytree(EXAMPLE, tmp_path / "gauge")
    return tmp_path / "gauge" / "campaign.yaml"


def judged(campaign, upper):
    text = campaign.read_text()
    rule = "decision: {rule: simple acceptance}"
    campaign.write_text(text + f"requirements:\n  - {{id: R1, quantity: l, limits: {{upper: {upper} nm}}, {rule}}}\n")


def test_status_0_when_done(campaign, tmp_path, capsys):
    assert main(["run", str(campaign), "--output", str(tmp_path / "out")]) == 0
    assert "50000838" in capsys.readouterr().out
    assert json.loads((tmp_path / "out" / "gum-h1-end-gauge" / "results.json").read_bytes())["results"]


def test_status_1_when_a_requirement_fails(campaign, tmp_path):
    judged(campaign, 50000700)
    assert main(["run", str(campaign), "--output", str(tmp_path)]) == 1


def test_status_0_when_a_requirement_passes(campaign, tmp_path):
    judged(campaign, 50001000)
    assert main(["run", str(campaign), "--output", str(tmp_path)]) == 0


def test_status_2_for_bad_input_with_every_fault_on_stderr(campaign, tmp_path, capsys):
    campaign.write_text(campaign.read_text().replace("215 nm", "215 kg").replace("derived:", "derivd:"))
    assert main(["run", str(campaign), "--output", str(tmp_path / "out")]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert f"{campaign}:7:" in told.err
    assert "derivd" in told.err
    assert not (tmp_path / "out").exists()


def test_a_bad_campaign_does_not_stop_the_others(campaign, tmp_path, capsys):
    bad = tmp_path / "bad.yaml"
    bad.write_text("format: metrology-campaign/1\nid: bad\n")
    assert main(["run", str(bad), str(campaign), "--output", str(tmp_path)]) == 2
    assert (tmp_path / "gum-h1-end-gauge" / "results.json").exists()
    assert "title" in capsys.readouterr().err


def test_json_stands_alone_on_stdout(campaign, tmp_path, capsys):
    assert main(["run", "--json", str(campaign), "--output", str(tmp_path)]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert document["schema"] == "metrology-results/1"


def test_check_tells_faults_as_json(campaign, capsys):
    campaign.write_text(campaign.read_text().replace("215 nm", "2,15 nm"))
    assert main(["check", "--json", str(campaign)]) == 2
    (entry,) = json.loads(capsys.readouterr().out)
    assert [set(fault) for fault in entry["faults"]] == [{"where", "got", "expected", "fix", "edit"}]


def test_check_of_a_file_that_is_not_there(tmp_path, capsys):
    assert main(["check", str(tmp_path / "none.yaml")]) == 2
    assert "none.yaml" in capsys.readouterr().err


def test_unknown_command_is_usage():
    with pytest.raises(SystemExit) as stop:
        main(["rune", "x"])
    assert stop.value.code == 2


@pytest.mark.long
def test_new_campaign_runs_at_once(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "trial"]) == 0
    assert main(["check", "--for", "17025", "campaigns/trial"]) == 0
    assert main(["run", "campaigns/trial"]) == 0
    assert (tmp_path / "reports" / "trial" / "results.json").exists()
    assert main(["new", "trial"]) == 2
    assert "trial" in capsys.readouterr().err


def test_schema_is_the_one_in_docs(capsys):
    assert main(["schema"]) == 0
    assert capsys.readouterr().out == (ROOT / "docs" / "campaign.schema.json").read_text(encoding="utf-8")


@pytest.mark.long
def test_same_inputs_give_the_same_bytes_in_any_locale_and_timezone(campaign, tmp_path):
    made = []
    for name, change in (("a", {}), ("b", {"LC_ALL": "de_DE.UTF-8", "TZ": "Asia/Tokyo", "PYTHONHASHSEED": "7"})):
        command = [sys.executable, "-m", "metrology", "run", str(campaign), "--output", str(tmp_path / name)]
        subprocess.run(command, env=os.environ | change, check=True, capture_output=True)
        made.append((tmp_path / name / "gum-h1-end-gauge" / "results.json").read_bytes())
    assert made[0] == made[1]


def test_help_and_import_load_nothing_heavy():
    program = (
        "import sys, metrology.cli; metrology.cli.parser().format_help(); "
        "heavy = {'numpy', 'pydantic', 'matplotlib', 'numba', 'weasyprint', 'scipy'}; "
        "print(sorted(heavy & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"
