"""The software bill of materials, of what `cyclonedx-py environment` says of an environment.

Reads its JSON from standard input and writes sbom.cdx.json: names, versions, licences and what
depends on what. Addresses, and the packages that every environment has, are left out.
"""

import json
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

PATH = Path(__file__).parents[2] / "sbom.cdx.json"
OF_THE_ENVIRONMENT = ("habilis", "pip", "setuptools")
IN_PROSE = {"protobuf": "BSD-3-Clause", "ray": "Apache-2.0", "stormpy": "GPL-3.0-only"}
KEPT = ("bom-ref", "licenses", "name", "purl", "type", "version")


def materials(found: dict[str, Any], version: str) -> dict[str, Any]:
    """The bill of a version of Habilis."""
    own = f"habilis=={version}"
    components = [c for c in found["components"] if c["name"].lower() not in OF_THE_ENVIRONMENT]
    there = {component["bom-ref"] for component in components}
    depend = {
        one["ref"]: sorted(there & {*one.get("dependsOn", ())}) for one in found["dependencies"]
    }
    asked = names_asked_for()
    roots = [one for one in depend.get("root-component", []) if _plain(one) in asked]
    return {
        "$schema": found["$schema"],
        "bomFormat": found["bomFormat"],
        "specVersion": found["specVersion"],
        "version": 1,
        "metadata": {
            "component": {
                "bom-ref": own,
                "licenses": [{"license": {"id": "MIT"}}],
                "name": "habilis",
                "purl": f"pkg:pypi/habilis@{version}",
                "type": "library",
                "version": version,
            }
        },
        "components": [_component(one) for one in components],
        "dependencies": [
            {"ref": own, "dependsOn": roots},
            *({"ref": ref, "dependsOn": depend.get(ref, [])} for ref in sorted(there)),
        ],
    }


def names_asked_for() -> set[str]:
    """The packages that users install directly: those of development are in no wheel."""
    project = tomllib.loads((PATH.parent / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    some = [extras[extra] for extra in extras if extra not in ("dev", "docs")]
    return {_plain(one) for part in (project["dependencies"], *some) for one in part}


def _plain(requirement: str) -> str:
    """The name in a requirement, as indexes compare names."""
    return re.sub(r"[-_.]+", "-", re.split(r"[\[<>=~ ]", requirement)[0]).lower()


def _component(found: dict[str, Any]) -> dict[str, Any]:
    kept = {key: found[key] for key in KEPT if key in found}
    if not kept.get("licenses"):  # its metadata name the licence in words that no standard knows
        kept["licenses"] = [{"license": {"id": IN_PROSE[found["name"]]}}]
    return kept


if __name__ == "__main__":
    import habilis

    bill = materials(json.load(sys.stdin), habilis.__version__)
    PATH.write_text(json.dumps(bill, indent=1) + "\n", "utf-8")
