"""JSON schemas of report.json and certificate.json, held against what is written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import eggbox, miura
from domes import dome, task
from jsonschema import Draft202012Validator
from jsonschema.exceptions import ValidationError

import inverse
from inverse.certify.certificate import LIMITS
from inverse.cli import commands
from inverse.repair.repairing import Repair
from inverse.results import saving, schema

TUBE = {
    "name": "tube",
    "pattern": {"kind": "tube", "size": [4, 4]},
    "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 4]]}, "radius": [[0, 1.0], [1, 0.9]]},
}


def tube() -> inverse.Result:
    return inverse.solve(TUBE)


def packed() -> inverse.Result:
    return inverse.solve(task(constraints={"footprint": {"state": 150, "width": 9, "height": 9}}))


def interrupted() -> inverse.Result:
    def stop(_: str, progress: inverse.Progress) -> None:
        raise KeyboardInterrupt

    return inverse.solve(task(), watch=stop)


def not_a_number() -> inverse.Result:
    steep = {"height": "sqrt(1 - x^2)", "domain": [[-1, 1], [-1, 1]]}  # which has no slope at its sides
    return inverse.solve(task(target=steep, fit={"points": "vertices"}))


def infeasible() -> inverse.Result:
    apart = [{"vertices": [0], "to": {"point": [-1.7, 0, 0]}}, {"vertices": [10], "to": {"point": [1.7, 0, 0]}}]
    return inverse.solve(task(constraints={"anchors": apart}, solver={"max_iterations": 5}))


def repaired() -> Repair:
    sheet = eggbox()
    return inverse.repair(
        sheet.moved_to(sheet.vertices_coords + 1e-4 * np.random.default_rng(0).standard_normal((25, 3)))
    )


def repaired_crease_pattern() -> Repair:
    inverse.write(miura(), "sheet.fold")
    document = json.loads(Path("sheet.fold").read_text())
    kept = {"edges_assignment": document["edges_assignment"]}
    for key in ("edges_vertices", "faces_vertices"):
        kept[key] = [[v + 1 for v in row] for row in document[key]]
    corners = [point[:2] for point in document["file_frames"][0]["vertices_coords"]]
    loose = [9, 9]  # in no facet
    Path("flat.fold").write_text(json.dumps(kept | {"vertices_coords": [loose, *corners]}))
    return inverse.repair("flat.fold")


@pytest.mark.parametrize(
    ("make", "ending"),
    [
        (dome, "solved"),
        (tube, "solved"),
        (packed, "solved"),
        (interrupted, "interrupted"),
        (not_a_number, "not_a_number"),
        (infeasible, "infeasible"),
        (repaired, None),
        (repaired_crease_pattern, None),
    ],
)
@pytest.mark.usefixtures("registered")
def test_what_is_written_has_its_schema(
    make: Callable[[], inverse.Result | Repair],
    ending: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    result = make()
    saving.save(result, Path("out"), pictures="none")
    report, certificate = (json.loads(Path(f"out/{name}.json").read_text()) for name in ("report", "certificate"))
    assert report.get("ending") == ending
    for name, document in (("report", report), ("certificate", certificate)):
        assert commands.run(["schema", name]) == 0
        shape = json.loads(capsys.readouterr().out)
        Draft202012Validator.check_schema(shape)
        Draft202012Validator(shape).validate(document)


def spoiled(change: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    report = json.loads(json.dumps(dome().report | {"versions": {}, "notes": []}))
    change(report)
    return report


@pytest.mark.parametrize(
    "change",
    [
        lambda report: report.update(surplus=1),
        lambda report: report.pop("status"),
        lambda report: report["fit"].update(rms="small"),
        lambda report: report["fit"].pop("max"),
        lambda report: report["attempts"][0].update(iterations=-0.5),
        lambda report: report["attempts"][0].update(surplus=1),
        lambda report: report["footprint"]["developed"].pop("area"),
        lambda report: report["verdict"]["violations"]["planarity"].update(value="none"),
        lambda report: report["specification"].update(surplus=1),
        lambda report: report.update(ending="well"),
    ],
)
def test_other_reports_have_not(change: Callable[[dict[str, Any]], object]) -> None:
    Draft202012Validator(schema.report()).validate(spoiled(lambda _: None))
    with pytest.raises(ValidationError):
        Draft202012Validator(schema.report()).validate(spoiled(change))


def test_a_certificate_has_every_check_with_its_limit() -> None:
    document = dome().certificate.document()
    shape = Draft202012Validator(schema.certificate())
    shape.validate(document)
    for name in LIMITS:
        checks = document["checks"]
        for other in ({**checks[name], "limit": 7.0}, {**checks[name], "more": 1}, None):
            changed = {key: one for key, one in checks.items() if key != name}
            assert not shape.is_valid(document | {"checks": changed | ({name: other} if other else {})})


def test_everything_told_is_described() -> None:
    properties = schema.report()["$defs"]["Solve"]["properties"]
    assert [name for name, shape in properties["fit"]["properties"].items() if "description" not in shape] == []
    assert "diagonal" in properties["fit"]["properties"]["rms_relative"]["description"]
    assert [name for name, shape in schema.certificate()["properties"].items() if "description" not in shape] == []
