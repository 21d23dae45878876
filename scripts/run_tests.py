#!/usr/bin/env python3
"""Runs the suites that ./test has built, counts all tests, and finally prints `N passed, M failed`.

    run_tests.py list < ctest.json      names of the C++ suites, one per line
    run_tests.py run --root DIR ...     see ./test
"""

import argparse
import concurrent.futures
import dataclasses
import json
import os
import pathlib
import re
import subprocess
import sys
import time

FAST_SECONDS, BROWSER_SECONDS, SLOW_SECONDS, SOAK_SECONDS = 600, 1500, 3000, 4500  # time limits; a suite that exceeds its limit is ended and fails


@dataclasses.dataclass
class Outcome:
    """Result of one suite. A suite that ran no test has failed, unless all its tests are slow and slow tests were not requested."""

    suite: str
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    seconds: float = 0.0
    report: str = ""
    note: str = ""

    def line(self):
        verdict = "ok  " if self.failed == 0 else "FAIL"
        skipped = f", {self.skipped} skipped" if self.skipped else ""
        note = f"  ({self.note})" if self.note else ""
        return f"{verdict} {self.suite:<28} {self.passed:>5} passed, {self.failed} failed{skipped}  {self.seconds:6.1f} s{note}"


def run(command, seconds, **options):
    """Exit status and output of a command; it is ended after `seconds`, with status 124."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=seconds, errors="replace",
                              stdin=subprocess.DEVNULL, **options)
        return done.returncode, done.stdout
    except subprocess.TimeoutExpired as late:
        output = late.stdout or b""
        output = output if isinstance(output, str) else output.decode(errors="replace")
        return 124, f"{output}\nended: still running after {seconds} s\n"


def list_programs():
    for test in json.load(sys.stdin)["tests"]:
        print(test["name"])


def gtest_suite(name, program, pattern, slow, results, seconds):
    """Runs a GoogleTest program and counts the tests of its JSON report."""
    outcome = Outcome(name)
    listed_status, listed = run([program, "--gtest_list_tests"], seconds)
    if listed_status != 0 or not re.search(r"^  \S", listed, re.M):
        outcome.failed, outcome.report = 1, f"{program} lists no tests\n{listed}"
        return outcome
    report = results / (name.replace("/", "-") + ".json")
    chosen = pattern or "*"
    if not slow and not pattern:
        chosen = "*-Slow*"
    status, output = run([program, f"--gtest_filter={chosen}", f"--gtest_output=json:{report}", "--gtest_brief=1"], seconds,
                         cwd=pathlib.Path(program).parent)
    messages = []
    try:
        suites = json.loads(report.read_text(errors="replace"))["testsuites"]
    except (OSError, ValueError, KeyError):
        outcome.failed, outcome.report = 1, f"{program} ended with status {status} without writing a report\n{output}"
        return outcome
    for suite in suites:
        for test in suite["testsuite"]:
            if test.get("failures"):
                outcome.failed += 1
                messages += [f"{suite['name']}.{test['name']}\n{failure['failure']}" for failure in test["failures"]]
            elif test.get("result") == "SKIPPED":
                outcome.skipped += 1
            elif test.get("status") == "RUN":
                outcome.passed += 1
    if status != 0 and outcome.failed == 0:
        outcome.failed, messages = 1, [f"{program} ended with status {status}\n{output}"]
    if outcome.passed + outcome.failed + outcome.skipped == 0 and not pattern:
        outcome.note = "all its tests are slow; run ./test --all"
    outcome.report = "\n\n".join(messages)
    if outcome.skipped:
        reasons = set(re.findall(r"^.*: Skipped\n(.+)$", output, re.M))
        outcome.note = "; ".join(sorted(reasons))[:160]
    return outcome


def vitest_suite(root, results):
    outcome = Outcome("web")
    report = results / "web.json"
    status, output = run(["npx", "--no-install", "vitest", "run", "--reporter=json", f"--outputFile={report}"], FAST_SECONDS,
                         cwd=root / "web")
    try:
        counts = json.loads(report.read_text())
        outcome.passed, outcome.failed = counts["numPassedTests"], counts["numFailedTests"]
        outcome.skipped = counts["numPendingTests"] + counts["numTodoTests"]
        messages = [f"{test['fullName']}\n" + "\n".join(test["failureMessages"])
                    for file in counts["testResults"] for test in file["assertionResults"] if test["status"] == "failed"]
        messages += [f"{file['name']}\n{file['message']}" for file in counts["testResults"]
                     if file["status"] == "failed" and not file["assertionResults"]]
    except (OSError, ValueError, KeyError):
        messages = [output]
    if (status != 0 and outcome.failed == 0) or outcome.passed + outcome.failed == 0:
        outcome.failed += 1
        messages = messages or [output]
    status, output = run(["npm", "run", "--silent", "typecheck"], FAST_SECONDS, cwd=root / "web")
    outcome.passed, outcome.failed = outcome.passed + (status == 0), outcome.failed + (status != 0)
    outcome.report = "\n\n".join(messages + ([f"types (npm run typecheck)\n{output}"] if status else []))
    return outcome


def lines_suite(name, command, seconds, **options):
    """Runs a program that prints a line for each test: `ok ...`, `not ok ...` or `skip ...`."""
    outcome = Outcome(name)
    status, output = run(command, seconds, **options)
    outcome.passed = len(re.findall(r"^ok\b", output, re.M))
    outcome.failed = len(re.findall(r"^not ok\b", output, re.M))
    outcome.skipped = len(re.findall(r"^skip\b", output, re.M))
    if (status != 0 and outcome.failed == 0) or outcome.passed + outcome.failed + outcome.skipped == 0:
        outcome.failed += 1
        output += f"\n{' '.join(map(str, command))} ended with status {status}"
    outcome.report = re.sub(r"^ok\b(?!.*second attempt).*\n", "", output, flags=re.M) if outcome.failed else ""
    repeated = re.findall(r"^ok (.* at the second attempt.*)$", output, re.M)
    outcome.note = "; ".join(repeated + re.findall(r"^skip\b *(.*)$", output, re.M))[:400]
    return outcome


def timed(suite, *arguments, **options):
    began = time.monotonic()
    outcome = suite(*arguments, **options)
    outcome.seconds = time.monotonic() - began
    return outcome


def run_all(options):
    root, results = pathlib.Path(options.root), pathlib.Path(options.results)
    began = time.monotonic()
    outcomes = []

    def report(outcome):
        outcomes.append(outcome)
        print(outcome.line(), flush=True)
        if outcome.failed:
            print("\n" + outcome.report.strip() + "\n", flush=True)

    os.environ["UGOKI_BIN"] = str(root / "build/release/bin/ugoki")
    os.environ["UGOKI_WEB"] = str(root / "web/dist")
    os.environ["ASAN_OPTIONS"] = "detect_leaks=1:strict_string_checks=1:detect_stack_use_after_return=1"
    os.environ["UBSAN_OPTIONS"] = "print_stacktrace=1:halt_on_error=1"
    for preset in options.programs:
        programs = [(name, str(root / "build" / preset / "bin" / f"ugoki_{name}_test"))
                    for name in (results / f"{preset}.suites").read_text().split()]
        slow = options.slow and preset == "release"
        seconds = SLOW_SECONDS if options.slow or preset != "release" else FAST_SECONDS
        with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            running = [pool.submit(timed, gtest_suite, name if preset == "release" else f"{name} [{preset}]", program,
                                   options.pattern, slow, results, seconds) for name, program in programs]
            for done in concurrent.futures.as_completed(running):
                report(done.result())
    if options.words:
        report(timed(lines_suite, "words", ["bash", "-c", "scripts/words.py --self-test && scripts/lint words"], FAST_SECONDS, cwd=root))
    if options.wasm:
        report(timed(lines_suite, "wasm", ["node", str(root / "tests/wasm/run.mjs"), str(root / "build/wasm/bin"),
                                         str(root / "build/release/bin")], FAST_SECONDS, cwd=root))
    if options.web:
        report(timed(vitest_suite, root, results))
    if options.e2e:
        report(timed(lines_suite, "e2e", ["npm", "run", "--silent", "e2e"] + (["--", "--slow"] if options.slow else []), BROWSER_SECONDS, cwd=root / "web"))
    if options.e2e and options.slow:
        report(timed(lines_suite, "soak", ["node", str(root / "benchmarks/studio/soak.mjs")], SOAK_SECONDS, cwd=root / "web"))
    if options.export:
        report(timed(lines_suite, "export", ["node", "e2e/export.mjs"] + (["--slow"] if options.slow else []),
                     SLOW_SECONDS if options.slow else FAST_SECONDS, cwd=root / "web"))
    if options.cluster:
        report(timed(lines_suite, "cluster", ["python3", str(root / "tests/cluster/run.py"), os.environ["UGOKI_BIN"]], SLOW_SECONDS))
    if options.package:
        report(timed(lines_suite, "package", ["python3", str(root / "tests/package/run.py"), str(root)], SLOW_SECONDS))
    if options.unbuilt:
        report(Outcome("build", failed=1, report="The build failed; see above."))

    passed, failed, skipped = (sum(getattr(outcome, field) for outcome in outcomes) for field in ("passed", "failed", "skipped"))
    if passed == 0 and failed == 0:
        failed = 1
        print("No test ran: no test matches.")
    failing = [outcome.suite for outcome in outcomes if outcome.failed]
    print(f"{len(outcomes)} suites in {time.monotonic() - began:.1f} s" + (f"; failing: {', '.join(failing)}" if failing else ""))
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 1 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    verbs.add_parser("list")
    runner = verbs.add_parser("run")
    runner.add_argument("--root", required=True)
    runner.add_argument("--results", required=True)
    runner.add_argument("--pattern", default="")
    runner.add_argument("--programs", action="append", default=[], metavar="PRESET")
    for flag in ("--slow", "--words", "--wasm", "--web", "--e2e", "--export", "--cluster", "--package", "--unbuilt"):
        runner.add_argument(flag, action="store_true")
    options = parser.parse_args()
    if options.verb == "list":
        list_programs()
        return 0
    return run_all(options)


if __name__ == "__main__":
    sys.exit(main())
