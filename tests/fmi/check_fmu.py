"""Checks an FMU independently of the project: its zip, the rules for modelDescription.xml, and with checker.c the calls of its binary.

    check_fmu.py CHECKER FILE.fmu [STEP]

STEP is the communication step, s; by default that of the DefaultExperiment. Prints "WRONG: ..." for each fault; the exit status is then 1.
It uses no code of the project: only Python's zip and XML readers, and a C program with its own declarations of the FMI functions.
"""
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile

project = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))  # folder of the source tree

TYPES2 = {"Real", "Integer", "Boolean", "String", "Enumeration"}
TYPES3 = {"Float32", "Float64", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
          "Boolean", "String", "Binary", "Enumeration", "Clock"}
CAUSALITIES = {"parameter", "calculatedParameter", "input", "output", "local", "independent", "structuralParameter"}
# Allowed combinations of causality and variability (FMI 2.0, table on page 49; FMI 3.0, section 2.4.7.4).
ALLOWED = {"parameter": {"fixed", "tunable"}, "calculatedParameter": {"fixed", "tunable"}, "input": {"discrete", "continuous"},
           "output": {"constant", "discrete", "continuous"}, "local": {"constant", "fixed", "tunable", "discrete", "continuous"},
           "independent": {"continuous"}}
problems = []


def need(condition, text):
    """Records the fault `text` if the condition is false."""
    if not condition:
        problems.append(text)


def scalar_variables(root, version):
    """One tuple for each variable: (name, type, reference, causality, variability, initial, start, count, XML element with min and max)."""
    out = []
    for outer in root.find("ModelVariables"):
        inner = outer
        if version == 2:
            need(outer.tag == "ScalarVariable" and len(outer) >= 1, f"<{outer.tag}> is not a variable")
            inner = outer[0]
        kind = inner.tag
        need(kind in (TYPES2 if version == 2 else TYPES3), f"unknown type {kind}")
        count = 1
        for d in inner.findall("Dimension"):
            need(version == 3 and ("start" in d.attrib) != ("valueReference" in d.attrib), "a Dimension has a start or a valueReference")
            count *= int(d.get("start", "1"))
        start = inner.get("start")
        if version == 3 and kind == "String":
            starts = [s.get("value") for s in inner.findall("Start")]
            start = starts[0] if starts else None
        causality = outer.get("causality", "local")
        variability = outer.get("variability", "continuous" if version == 2 or kind.startswith("Float") else "discrete")
        out.append((outer.get("name"), kind, int(outer.get("valueReference")), causality, variability, outer.get("initial"), start, count, inner))
    return out


def check_variables(variables, root, version):
    names = [v[0] for v in variables]
    need(len(names) == len(set(names)), "names are not unique")
    need(all(n for n in names), "a variable has no name")
    references = [v[2] for v in variables]
    need(len(references) == len(set(references)), "value references are not unique")
    units = {u.get("name") for u in root.findall("UnitDefinitions/Unit")}
    types = {t.get("name") for t in root.findall("TypeDefinitions/*")}
    independent = 0
    for name, kind, _, causality, variability, initial, start, count, inner in variables:
        need(causality in CAUSALITIES, f"{name}: causality {causality}")
        need(variability in ALLOWED.get(causality, set()), f"{name}: {causality} with {variability}")
        if kind not in ("Real", "Float32", "Float64"):
            need(variability != "continuous", f"{name}: only real variables are continuous")
        if causality == "independent":
            independent += 1
            need(start is None and initial is None, f"{name}: the independent variable has neither start nor initial")
        if causality == "input":
            need(initial is None, f"{name}: an input has no initial")
            need(start is not None, f"{name}: an input has a start")
        if causality == "parameter":
            need(initial in (None, "exact") and start is not None, f"{name}: a parameter has an exact start")
        if causality == "output" and initial == "calculated":
            need(start is None, f"{name}: a calculated output has no start")
        if inner.get("unit"):
            need(inner.get("unit") in units, f"{name}: the unit {inner.get('unit')} is not defined")
        if inner.get("declaredType"):
            need(inner.get("declaredType") in types, f"{name}: the type is not defined")
        if kind == "Enumeration":
            need(inner.get("declaredType"), f"{name}: an enumeration has a declared type")
        if start is not None and kind not in ("String", "Boolean"):
            numbers = [float(s) for s in start.split()]
            need(len(numbers) in (1, count), f"{name}: {len(numbers)} starts for {count}")
            for x in numbers:
                need(x >= float(inner.get("min", "-inf")) and x <= float(inner.get("max", "inf")), f"{name}: the start is out of its range")
        if inner.get("min") and inner.get("max"):
            need(float(inner.get("min")) <= float(inner.get("max")), f"{name}: min is above max")
    need(independent == 1 if version == 3 else independent <= 1, "one variable is independent")


def check_structure(variables, root, version):
    structure = root.find("ModelStructure")
    need(structure is not None, "there is no ModelStructure")
    if version == 2:
        key = {i + 1: v for i, v in enumerate(variables)}
        listed = [(int(u.get("index")), u) for u in structure.findall("Outputs/Unknown")]
        initial = [int(u.get("index")) for u in structure.findall("InitialUnknowns/Unknown")]
        outputs = [i for i, v in key.items() if v[3] == "output"]
        calculated = [i for i, v in key.items() if v[3] in ("output", "calculatedParameter") and v[5] in ("approx", "calculated", None)
                      and v[6] is None]
    else:
        key = {v[2]: v for v in variables}
        listed = [(int(u.get("valueReference")), u) for u in structure.findall("Output")]
        initial = [int(u.get("valueReference")) for u in structure.findall("InitialUnknown")]
        outputs = [v[2] for v in variables if v[3] == "output"]
        calculated = [v[2] for v in variables if v[3] in ("output", "calculatedParameter") and v[5] in ("approx", "calculated", None)
                      and v[6] is None]
    need(sorted(i for i, _ in listed) == sorted(outputs), "the outputs of ModelStructure are not the outputs")
    missing = set(calculated) - set(initial)
    others = [key[i] for i in set(initial) - set(calculated) if i in key]  # derivatives of states are allowed
    need(not missing and len(initial) == len(set(initial)) and all(i in key for i in initial)
         and all(v[3] == "local" and v[5] in ("approx", "calculated") for v in others),
         "the initial unknowns are not the variables that are calculated at the start")
    if version == 2:
        need(initial == sorted(initial), "InitialUnknowns are in the order of their indices")
    for _, unknown in listed:
        for d in unknown.get("dependencies", "").split():
            need(int(d) in key, f"a dependency on {d}, which is not a variable")
            need(int(d) in key and key[int(d)][3] != "output", f"a dependency on {d}, which is an output")
    return outputs


def main():
    checker, path = sys.argv[1:3]
    with zipfile.ZipFile(path) as archive, tempfile.TemporaryDirectory() as folder:
        need(archive.testzip() is None, "the zip is damaged")
        names = archive.namelist()
        need(len(names) == len(set(names)), "an entry exists twice")
        need(all(not n.startswith("/") and ".." not in n and "\\" not in n for n in names), "a name leads out of the zip")
        archive.extractall(folder)
        root = ET.parse(folder + "/modelDescription.xml").getroot()
        need(root.tag == "fmiModelDescription", "the root element")
        text = open(folder + "/modelDescription.xml", encoding="utf-8").read()
        need(all(path not in text for path in (project, tempfile.gettempdir(), os.path.expanduser("~") + "/")), "paths of the machine")
        version = 2 if root.get("fmiVersion") == "2.0" else 3
        need(root.get("fmiVersion") in ("2.0", "3.0"), "fmiVersion")
        token = root.get("guid" if version == 2 else "instantiationToken")
        need(bool(token) and bool(root.get("modelName")), "token and name")
        order = [c.tag for c in root]
        wanted = ["CoSimulation", "UnitDefinitions", "TypeDefinitions", "LogCategories", "DefaultExperiment", "ModelVariables", "ModelStructure"]
        need(order == [w for w in wanted if w in order], f"the order of elements: {order}")
        unit = root.find("CoSimulation")
        identifier = unit.get("modelIdentifier")
        need(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", identifier), "the model identifier")
        variables = scalar_variables(root, version)
        check_variables(variables, root, version)
        check_structure(variables, root, version)
        saves = unit.get("canGetAndSetFMUstate" if version == 2 else "canGetAndSetFMUState") == "true"
        serializes = unit.get("canSerializeFMUstate" if version == 2 else "canSerializeFMUState") == "true"
        binary = f"{folder}/binaries/{'linux64' if version == 2 else 'x86_64-linux'}/{identifier}.so"
        need(os.path.exists(binary), "the binary")
        experiment = root.find("DefaultExperiment")
        step = sys.argv[3] if len(sys.argv) > 3 else experiment.get("stepSize", "0.01")
        table = "".join(f"{kind} {causality} {variability} {reference} {count} {float(start) if kind not in ('String', 'Boolean') and start and count == 1 else 0}\n"
                        for _, kind, reference, causality, variability, _, start, count, _ in variables)
        resources = "file://" + folder + "/resources" if version == 2 else folder + "/resources/"
        if not problems:
            run = subprocess.run([checker, str(version), binary, token, resources, step, str(int(saves)), str(int(serializes))], input=table,
                                 text=True, capture_output=True, timeout=60)
            sys.stdout.write(run.stdout)
            need(run.returncode == 0, f"the calling sequence: status {run.returncode}\n{run.stdout}{run.stderr}")
    for p in problems:
        print("WRONG:", p)
    return 1 if problems else 0


sys.exit(main())
