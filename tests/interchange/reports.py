#!/usr/bin/env python3
"""reports.py EYEBOX SCRATCH ASSET... -- eyebox's SARIF and JUnit reports against the programs and schemas of others.

SARIF: the OASIS schema (sarif-schema-2.1.0.json of oasis-tcs/sarif-spec, given as SCRATCH/sarif-schema-2.1.0.json) and
Microsoft's Sarif.Multitool (npm @microsoft/sarif-multitool) with its rules and those that GitHub asks for. JUnit:
the schema of Jenkins' xUnit plugin, if SCRATCH/junit-10.xsd is there. GitHub's and Azure's limits are counted.
Needs: Python with jsonschema (and lxml for the XSD), npm.
"""
import json
import pathlib
import re
import subprocess
import sys

import jsonschema

program, scratch, assets = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]
failed = False


def run(style):
    done = subprocess.run([program, "validate", *assets, "--format", style], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


sarif = scratch / "eyebox.sarif"
sarif.write_text(run("sarif"))
log = json.loads(sarif.read_text())
schema = json.loads((scratch / "sarif-schema-2.1.0.json").read_text())
checker = jsonschema.validators.validator_for(schema)
errors = list(checker(schema, format_checker=checker.FORMAT_CHECKER).iter_errors(log))
print(f"OASIS schema ({checker.__name__}): {len(errors)} errors, {len(log['runs'][0]['results'])} results")
for error in errors[:10]:
    print("  ", list(error.absolute_path), error.message[:200])
failed |= bool(errors)

tool = scratch / "node_modules" / "@microsoft" / "sarif-multitool-linux" / "Sarif.Multitool"
if not tool.exists():
    subprocess.run(["npm", "install", "--silent", "--prefix", scratch, "@microsoft/sarif-multitool"], check=True)
tool.chmod(0o755)
said, config = scratch / "multitool.sarif", scratch / "multitool.xml"
environment = {"DOTNET_SYSTEM_GLOBALIZATION_INVARIANT": "1", "HOME": str(scratch)}
subprocess.run([tool, "export-validation-config", config], check=True, capture_output=True, env=environment)
# The rules that GitHub asks for (GH1001 and on) are off as the program comes.
text = config.read_text(encoding="utf-8-sig")
github = r'(<Properties Key="GH\d{4}[^>]*>\s*<Property Key="RuleEnabled" Value=")Default'
config.write_text(re.sub(github, r"\1Error", text), encoding="utf-8")
for kinds in ("Sarif", "Ghas"):
    said.unlink(missing_ok=True)
    command = [tool, "validate", sarif, "--output", said, "--log", "ForceOverwrite", "--config", config, "--rule-kind", kinds,
               "--level", "Error;Warning;Note"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if not said.exists():
        print("Sarif.Multitool did not run:", (done.stdout + done.stderr)[-400:])
        failed = True
        continue
    found = [result for one in json.loads(said.read_text())["runs"] for result in one.get("results", [])]
    print(f"Sarif.Multitool, {kinds}: exit {done.returncode}, {len(found)} results")
    counts = {}
    for result in found:
        counts.setdefault((result["ruleId"], result.get("level", "warning")), []).append(result["message"].get("arguments"))
    for (rule, level), arguments in sorted(counts.items()):
        print(f"  {rule} {level}: {len(arguments)}, first: {str(arguments[0])[:160]}")
        failed |= level == "error"

junit = scratch / "eyebox.xml"
junit.write_text(run("junit"))
xsd = scratch / "junit-10.xsd"
if xsd.exists():
    from lxml import etree

    schema = etree.XMLSchema(etree.parse(str(xsd)))
    sound = schema.validate(etree.parse(str(junit)))
    print("JUnit XSD:", "valid" if sound else schema.error_log)
    failed |= not sound
sys.exit(failed)
