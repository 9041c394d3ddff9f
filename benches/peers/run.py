#!/usr/bin/env python3
"""Measures sfera and other renderers on the same scenes in the same run: `make peers`.

Builds the peers whose tools are installed, names those it skips, prints the tables and saves them beside this file as
results.md and results.csv. Needs Python's standard library, cargo, and gcc and g++ for the peers in C. Everything it makes is under
target/peers.

In memory: from spheres in memory to RGB in memory, the tree's build included, threads warmed. The programs take turns,
a few runs each, three times around; the figures are medians of all their runs. Embree's modes are each tried first; its
best two by build + trace then take their turns, and the better one is reported. `splat` is the fastest inexact
rasteriser that we could write, with 8 and with 16 lanes; `bounds ignored` is sfera's engine without its error bounds.
Reading: the reader of sfera against merely reading the text and parsing its numbers with Rust's standard library.
Whole command: from exec to exit, also in turns, the image file removed before every run.
Peak memory: of the whole process, the scene's text and the pages of the mapped image among it.
Wrong pixels: against the picture of sfera's default method.
"""

import argparse
import csv
import itertools
import json
import os
import re
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "peers"
ROUNDS = 3
BRUTE_FORCE = 4e9  # pixels times spheres; brute force is not run above this
SCENES = "example,example-8k,cloud-1e2,cloud-1e3,cloud-1e4,cloud-1e5,cloud-1e6,cloud-1e7,"
SCENES += "frustum-1e2,frustum-1e3,frustum-1e4,frustum-1e5,frustum-1e6,molecule-1e3,molecule-1e4,lattice-54872,"
SCENES += "floor-1e3,among-1e3,among-1e5"
LIMIT = 10  # seconds; methods of sfera that take longer for one picture are not measured
FLOORS = [f"{size}-{way}" for size in ("truncate", "reserve") for way in ("touch", "populate", "huge")]
DEBIAN = {
    "Embree": "libembree-dev",
    "OpenMP": "gcc",
    "Tachyon": "tachyon",
    "POV-Ray": "povray",
    "floor": "gcc",
    "splat": "gcc, and a CPU with AVX2",
    "VTK": "libegl1 libgl1-mesa-dri, and vtk and numpy from PyPI",
}


def say(text):
    print(text, file=sys.stderr, flush=True)


def output(command, limit=None):
    done = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True, timeout=limit)
    if done.returncode:
        raise RuntimeError(f"{Path(command[0]).name}: {done.stderr.strip()[-300:]}")
    return done.stdout


def median(samples):
    return statistics.median(samples)


class Peers:
    """The programs that could be built or found on this machine."""

    def __init__(self):
        WORK.mkdir(parents=True, exist_ok=True)
        self.missing = []
        cargo = ["cargo", "build", "--release", "--message-format=json"]
        cargo += ["--bench", "in_memory", "--bench", "families"]
        built = subprocess.run(cargo, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        self.rust = {}
        for line in built.stdout.splitlines():
            message = json.loads(line)
            if message.get("executable"):
                self.rust[message["target"]["name"]] = message["executable"]
        # The program as `make build` makes it, linked with its libraries.
        subprocess.run(["make", "build"], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
        self.rust["sfera"] = ROOT / "target" / "release" / "sfera"
        fast = ["-O3", "-march=native", "-fno-math-errno"]
        for tool in ("measure", "compare"):
            if not self.compile(tool, ["gcc", "-O2", f"{tool}.c"]):
                raise SystemExit("peers: a C compiler is needed to measure at all (Debian: apt-get install gcc)")
        self.openmp = self.compile("openmp", ["gcc", *fast, "-fopenmp", "openmp.c", "-lm"], "OpenMP")
        self.floor = self.compile("floor", ["gcc", "-O2", "-march=native", "floor.c", "-lpthread"], "floor")
        cxx = ["g++", "-std=c++17", *fast, "embree.cpp"]
        self.embree = self.compile("embree", [*cxx, "-lembree4", "-ltbb"]) or self.compile(
            "embree", [*cxx, "-lembree3", "-ltbb"], "Embree"
        )
        subprocess.run(["make", "splat"], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
        self.splats = {lanes: WORK / f"splat-{lanes}" for lanes in (8, 16) if (WORK / f"splat-{lanes}").exists()}
        if not self.splats:
            self.skip("splat")
        self.vtk = self.python_with_vtk()
        self.tachyon = self.find("tachyon", "Tachyon")
        self.povray = self.find("povray", "POV-Ray")
        for line in self.missing:
            say(line)

    def compile(self, name, command, peer=None):
        target = WORK / name
        target.unlink(missing_ok=True)
        if shutil.which(command[0]):
            done = subprocess.run([*command, "-o", str(target)], cwd=HERE, capture_output=True, text=True)
            if done.returncode == 0:
                return target
        if peer:
            self.skip(peer)
        return None

    def find(self, program, peer):
        path = shutil.which(program)
        if not path:
            self.skip(peer)
        return path

    def python_with_vtk(self):
        """The Python that `make peers-install` made, or the one that runs this."""
        for python in (WORK / "python" / "bin" / "python", sys.executable):
            if shutil.which(python) and not subprocess.run(
                [python, "-c", "import numpy, vtkmodules"], capture_output=True
            ).returncode:
                return python
        self.skip("VTK")
        return None

    def skip(self, peer):
        self.missing.append(f"skipped: {peer} (Debian: apt-get install {DEBIAN[peer]}, or make peers-install)")


class Scene:
    """A scene file, its spheres, and the same scene in the formats of other programs."""

    def __init__(self, name, path):
        self.name, self.path = name, path
        words = self.words()
        self.viewport = [float(word) for word in list(itertools.islice(words, 4))[1:]]
        self.background = list(itertools.islice(words, 4))[1:]
        self.count = int(list(itertools.islice(words, 2))[1])

    def words(self):
        with self.path.open() as file:
            for line in file:
                yield from line.split("#")[0].split()

    def spheres(self):
        words = itertools.islice(self.words(), 10, None)
        while sphere := list(itertools.islice(words, 8)):
            yield sphere[1:]

    def step(self, size):
        """Distance of two neighbouring pixels on the viewport."""
        return [extent / max(count - 1, 1) for extent, count in zip(self.viewport, size)]

    def tachyon(self, size):
        """Its pixel i (from 1) looks through left + i (right - left) / width, and so for rows from the bottom."""
        path = WORK / f"{self.name}-{size[0]}.dat"
        width, height, distance = self.viewport
        across, up = self.step(size)
        left, bottom = (-width / 2 - across) / distance, (-height / 2 - up) / distance
        right, top = left + across * size[0] / distance, bottom + up * size[1] / distance

        # A quarter is added, so that truncation to bytes gives the same colour.
        def colour(words):
            return " ".join(f"{(int(word) + 0.25) / 255:.6f}" for word in words)

        with path.open("w") as file:
            file.write(
                f"BEGIN_SCENE\nRESOLUTION {size[0]} {size[1]}\nCAMERA\nPROJECTION PERSPECTIVE\nZOOM 1\nASPECTRATIO 1\n"
                "ANTIALIASING 0\nRAYDEPTH 1\nCENTER 0 0 0\nVIEWDIR 0 0 1\nUPDIR 0 1 0\n"
                f"FRUSTUM {left:.17g} {right:.17g} {bottom:.17g} {top:.17g}\nEND_CAMERA\n"
                f"BACKGROUND {colour(self.background)}\n"
            )
            for x, y, z, radius, *rgb in self.spheres():
                file.write(
                    f"SPHERE CENTER {x} {y} {z} RAD {radius} TEXTURE AMBIENT 1 DIFFUSE 0 SPECULAR 0 OPACITY 1"
                    f" COLOR {colour(rgb)} TEXFUNC 0\n"
                )
            file.write("END_SCENE\n")
        return path

    def povray(self, size):
        """Its pixel i looks through the middle of the i-th of `width` cells: the window is one cell wider."""
        path = WORK / f"{self.name}-{size[0]}.pov"
        across, up = self.step(size)

        def colour(words):
            return ",".join(f"{int(word) / 255:.6f}" for word in words)

        with path.open("w") as file:
            file.write(
                "#version 3.7;\nglobal_settings { assumed_gamma 1 }\n"
                "#default { finish { ambient 0 diffuse 0 emission 1 } }\n"
                f"background {{ rgb <{colour(self.background)}> }}\n"
                f"camera {{ perspective location <0,0,0> direction <0,0,{self.viewport[2]}>"
                f" right <{across * size[0]:.17g},0,0> up <0,{up * size[1]:.17g},0> }}\n"
            )
            for x, y, z, radius, *rgb in self.spheres():
                file.write(f"sphere {{ <{x},{y},{z}>,{radius} pigment {{ rgb <{colour(rgb)}> }} }}\n")
        return path


class Table:
    columns = ["scene", "spheres", "width", "height", "threads", "what", "peer", "mode", "ms", "stages", "peak_mib"]
    columns += ["wrong_pixels", "times_sfera", "runs"]

    def __init__(self):
        self.rows = []

    def add(self, case, what, peer, mode, ms, stages="", peak=None, wrong=None, runs=0):
        scene, size, threads = case
        row = [scene.name, scene.count, *size, threads, what, peer, mode, ms, stages, peak, wrong, None, runs]
        self.rows.append(dict(zip(self.columns, row)))
        say(f"  {what}: {peer} {mode}: {ms:.3f} ms {stages} wrong {wrong}")

    def finish(self):
        def key(row):
            return [row[name] for name in ("scene", "width", "height", "threads", "what")]

        ours = {tuple(key(row)): row["ms"] for row in self.rows if row["peer"] == "sfera"}
        for row in self.rows:
            base = ours.get(tuple(key(row)))
            row["times_sfera"] = row["ms"] / base if base else None


class Run:
    def __init__(self, peers, runs):
        self.peers, self.runs, self.table = peers, runs, Table()

    def wrong(self, image, truth):
        return int(output([WORK / "compare", image, truth])) if truth else None

    def case(self, scene, size, threads):
        say(f"{scene.name} {size[0]} x {size[1]}, {threads} threads")
        case = (scene, size, threads)
        os.environ["RAYON_NUM_THREADS"] = str(threads)
        truth = WORK / "truth.ppm"
        try:
            output([self.peers.rust["sfera"], scene.path, truth, *size], LIMIT)
        except subprocess.TimeoutExpired:
            self.peers.missing.append(f"skipped: sfera on {scene.name}, {size[0]} x {size[1]}: more than {LIMIT} s")
            say(self.peers.missing[-1])
            truth = None
        self.reading(case)
        self.in_memory(case, truth)
        self.whole(case, truth)

    def reading(self, case):
        scene, _, threads = case
        command = [self.peers.rust["in_memory"], "read", scene.path, "--threads", threads, "--runs", self.runs]
        read = json.loads(output(command))
        self.table.add(case, "reading", "sfera", "reader", read["reader_ms"], runs=self.runs)
        self.table.add(case, "reading", "floor", "numbers parsed", read["numbers_ms"], runs=self.runs)

    def in_memory(self, case, truth):
        scene, size, threads = case
        image = WORK / "picture.ppm"
        each = max(1, -(-self.runs // ROUNDS))

        def ours(*more):
            command = [self.peers.rust["in_memory"], "draw", scene.path, *size, "--threads", threads]
            return json.loads(output([*command, "--runs", each, "--image", image, *more]))

        def program(binary, *more, runs=each):
            lines = output([*command_of(binary), scene.path, *size, threads, runs, *more]).splitlines()
            return [json.loads(line) for line in lines if line.startswith("{")]

        def command_of(binary):
            return [self.peers.vtk, HERE / "vtk_spheres.py"] if binary == "vtk" else [WORK / binary]

        def peak(binary, *more):
            command = [*command_of(binary), scene.path, *size, threads, 1, *more]
            return json.loads(output([WORK / "measure", 1, 60, image, WORK / "log", "--", *command]))["peak_kib"] / 1024

        turns = {("sfera", "default"): ours, ("sfera", "bounds ignored"): lambda: ours("--ignore-bounds")} if truth else {}
        for lanes in self.peers.splats:
            turns["splat", f"{lanes} lanes"] = lambda lanes=lanes: program(f"splat-{lanes}", image)[0]
        if self.peers.vtk and scene.count <= 1_000_000:
            turns["VTK", "sphere mapper"] = lambda: program("vtk", image)[0]
        if scene.count * size[0] * size[1] <= BRUTE_FORCE:
            turns["sfera", "textbook"] = lambda: ours("--method", "textbook")
            if self.peers.openmp:
                turns["OpenMP", "brute force"] = lambda: program("openmp", image)[0]
        if self.peers.embree and scene.count <= 1_000_000:
            modes = {
                mode["mode"]: median(mode["build"]) + median(mode["trace"])
                for mode in program("embree", runs=3)
            }
            for mode, ms in modes.items():
                self.table.add(case, "in memory, tried", "Embree", mode, ms, runs=3)
            for mode in sorted(modes, key=modes.get)[:2]:
                turns["Embree", mode] = lambda mode=mode: program("embree", mode, image)[0]

        samples, wrong = {}, {}
        for _ in range(ROUNDS):
            for turn, run in turns.items():
                for stage, times in run().items():
                    if isinstance(times, list):
                        samples.setdefault(turn, {}).setdefault(stage, []).extend(times)
                wrong[turn] = self.wrong(image, truth)

        found = []
        for (peer, mode), stages in samples.items():
            stages = dict(stages)
            fill = stages.pop("fill", None)
            total = stages.pop("total", None) or [sum(parts) for parts in zip(*stages.values())]
            text = ", ".join(f"{stage} {median(times):.3f}" for stage, times in stages.items())
            found.append((median(total), peer, mode, text, wrong[peer, mode], len(total)))
            if fill and mode == "default":
                self.table.add(case, "in memory", "floor", "fill", median(fill), runs=len(fill))
        best = min((row for row in found if row[1] == "Embree"), default=None)
        for row in found:
            ms, peer, mode, text, errors, runs = row
            if peer == "sfera" and mode == "textbook":
                peer = f"sfera --method {mode}"
            elif peer == "sfera" and mode != "default":
                peer = "sfera, inexact"
            if peer != "Embree" or row is best:
                memory = {
                    "OpenMP": lambda: peak("openmp"),
                    "Embree": lambda: peak("embree", mode),
                    "splat": lambda: peak(f"splat-{mode.split()[0]}"),
                    "VTK": lambda: peak("vtk"),
                }.get(peer)
                self.table.add(case, "in memory", peer, mode, ms, text, memory and memory(), errors, runs)

    def whole(self, case, truth):
        scene, size, threads = case
        image = WORK / "whole.ppm"
        sfera = [self.peers.rust["sfera"], scene.path, image, *size]
        commands = {("sfera", "default"): [*sfera, *self.options(threads)]} if truth else {}
        if self.peers.floor:
            bytes_written = len(f"P6\n{size[0]} {size[1]}\n255\n") + 3 * size[0] * size[1]
            for way in [*FLOORS, "reserve-write"]:
                commands["floor", way] = [self.peers.floor, way, image, bytes_written, threads]
        numbers = [self.peers.rust["in_memory"], "numbers", scene.path, "--threads", threads]
        commands["floor", "numbers parsed"] = numbers
        if self.peers.tachyon and scene.count <= 1_000_000:
            commands["Tachyon", "-lowshade"] = [
                *[self.peers.tachyon, scene.tachyon(size), "-o", image, "-format", "PPM"],
                *["-lowshade", "-numthreads", threads, "+V"],
            ]
        if self.peers.povray and scene.count <= 100_000:
            commands["POV-Ray", "+Q1"] = [
                *[self.peers.povray, f"+I{scene.povray(size)}", f"+O{image}", f"+W{size[0]}", f"+H{size[1]}"],
                *["+FP", "+Q1", "-D", "-A", f"+WT{threads}", "File_Gamma=1.0", "Dither=Off", "-V"],
            ]

        words = []
        for command in commands.values():
            words += ["--", *command]
        log = WORK / "log"
        for old in WORK.glob("log.*"):
            old.unlink()
        lines = output([WORK / "measure", self.runs, 15, image, log, *words]).splitlines()
        floors = []
        for index, ((peer, mode), line) in enumerate(zip(commands, lines)):
            result = json.loads(line)
            text = (WORK / f"log.{index}").read_text(errors="replace")
            if result["status"]:
                say(f"skipped: {peer} {mode} on {scene.name}: exit {result['status']}: {text.strip()[-200:]}")
                continue
            wrong = None
            if peer != "floor" and truth:
                image.unlink(missing_ok=True)
                output(commands[peer, mode])
                wrong = self.wrong(image, truth)
            row = [peer, mode, median(result["wall"]), self.stages(peer, text), result["peak_kib"] / 1024, wrong]
            row.append(len(result["wall"]))
            if mode in FLOORS:
                floors.append(row)
            else:
                self.table.add(case, "whole command", *row)
        if floors:
            best = min(floors, key=lambda row: row[2])
            for row in floors:
                self.table.add(case, "whole command" if row is best else "whole command, tried", *row)
        image.unlink(missing_ok=True)

    def options(self, threads):
        if not hasattr(self, "knows_threads"):
            self.knows_threads = "--threads" in output([self.peers.rust["sfera"], "--help"])
        return ["--threads", threads] if self.knows_threads else []

    @staticmethod
    def stages(peer, text):
        found = {}
        if peer == "Tachyon":
            words = {"parse": "Scene Parsing", "prepare": "Preprocessing", "trace": "Ray Tracing", "write": "Image I/O"}
            for name, word in words.items():
                found[name] = [1e3 * float(s) for s in re.findall(rf"{word} Time:\s*([\d.]+)", text)]
        if peer == "POV-Ray":
            for name, word in (("parse", "Parse"), ("prepare", "Bounding"), ("trace", "Trace")):
                found[name] = [1e3 * float(s) for s in re.findall(rf"{word} Time:.*?\(([\d.]+) seconds\)", text)]
        return ", ".join(f"{name} {median(times):.0f}" for name, times in found.items() if times)


def machine():
    model = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text())
    return f"{model[1] if model else 'unknown CPU'}, {os.cpu_count()} threads"


def markdown(table, peers, arguments):
    lines = ["# sfera and its peers", "", f"{arguments.date}, {machine()}."]
    lines += ["Written by `make peers`; `run.py` beside this file says what is measured and how.", ""]
    lines += [f"- {line}" for line in peers.missing] + ([""] if peers.missing else [])
    groups = {}
    for row in table.rows:
        if not row["what"].endswith("tried"):
            groups.setdefault((row["scene"], row["spheres"], row["width"], row["height"]), []).append(row)
    for (scene, spheres, width, height), rows in groups.items():
        lines += [f"## {scene}: {spheres} spheres, {width} x {height}", ""]
        lines += ["| what | threads | peer | mode | ms | times sfera | of it, ms | peak MiB | wrong pixels |"]
        lines += ["| --- | ---: | --- | --- | ---: | ---: | --- | ---: | ---: |"]
        rows.sort(key=lambda row: (row["what"], row["threads"], row["ms"]))
        for row in rows:
            cells = [row["what"], row["threads"], row["peer"], row["mode"], f"{row['ms']:.2f}"]
            cells.append("" if row["times_sfera"] is None else f"{row['times_sfera']:.2f}")
            cells.append(row["stages"])
            cells.append("" if row["peak_mib"] is None else f"{row['peak_mib']:.0f}")
            cells.append("" if row["wrong_pixels"] is None else row["wrong_pixels"])
            lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=9, help="at least so many runs of each (default 9)")
    parser.add_argument("--threads", default=f"1,{min(2, os.cpu_count())}", help="thread counts, by commas")
    parser.add_argument("--scenes", default=SCENES, help="which scenes, by commas: FAMILY-DIFFICULTY")
    parser.add_argument("--into", type=Path, default=HERE, help="folder of results.md and results.csv")
    arguments = parser.parse_args()
    arguments.date = subprocess.run(["date", "+%F"], capture_output=True, text=True).stdout.strip()

    peers = Peers()
    run = Run(peers, arguments.runs)
    for name in arguments.scenes.split(","):
        path = ROOT / "scenes" / "example.txt"
        if not name.startswith("example"):
            path = WORK / f"{name}.txt"
            family, difficulty = re.fullmatch(r"(\D+)-(.+)", name).groups()
            output([peers.rust["families"], family, difficulty, path])
        scene = Scene(name.removesuffix("-8k"), path)
        size = (7680, 4320) if name.endswith("-8k") else (1920, 1080)
        for threads in arguments.threads.split(","):
            run.case(scene, size, int(threads))
        run.table.finish()
        arguments.into.mkdir(parents=True, exist_ok=True)
        with (arguments.into / "results.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, Table.columns, lineterminator="\n")
            writer.writeheader()
            for row in run.table.rows:
                writer.writerow({k: f"{v:.4f}" if isinstance(v, float) else v for k, v in row.items()})
        text = markdown(run.table, peers, arguments)
        (arguments.into / "results.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
