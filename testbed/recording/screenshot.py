"""A picture of a recording as the viewer shows it, without a display.

    python -m testbed.recording.screenshot FILE.rrd OUT.png [--time S] [--size 1600x900]

Rerun's own headless viewer draws it; it needs a Vulkan driver, for which Debian's software one will do:
apt-get install mesa-vulkan-drivers libvulkan1. Ends with status 2 and one line if something is missing.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rerun_cli
from rerun.experimental import ViewerClient

from estimators.readers import read_log
from estimators.readers.rrd_chunks import TIMELINE
from testbed.arguments import Parser

_SOFTWARE_DRIVERS = Path("/usr/share/vulkan/icd.d")
_CURE = "needs a Vulkan driver; on Debian: apt-get install mesa-vulkan-drivers libvulkan1"
_START = 20.0  # [s] for the viewer to come up
_SETTLE = 3.0  # [s] for it to fetch and draw what the time asks for


def screenshot(recording: Path, picture: Path, seconds: float | None = None, size: str = "1600x900") -> None:
    """Save a PNG of the recording at a time [s] of its clock, two thirds into it by default. Raises ValueError."""
    if recording.suffix != ".rrd":
        raise ValueError(f"{recording}: not a recording, want a file that ends in .rrd")
    start, end = read_log(recording).span
    at = start + (end - start) * 2.0 / 3.0 if seconds is None else seconds
    if not start <= at <= end:
        raise ValueError(f"--time {at:g}: the recording runs from {start:g} to {end:g} s")
    width, _, height = size.partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) >= 100 and int(height) >= 100):
        raise ValueError(f"--size {size}: want WIDTHxHEIGHT in pixels, such as 1600x900")
    with tempfile.TemporaryDirectory() as scratch, (Path(scratch) / "log").open("w+") as log:
        port = _free_port()
        program = Path(rerun_cli.__file__).with_name("rerun")
        command = [str(program), str(recording), "--headless", "--bind", "127.0.0.1", "--port", str(port)]
        viewer = subprocess.Popen([*command, "--window-size", size], stdout=log, stderr=log, env=_environment(scratch))
        try:
            image = _picture(viewer, port, at)
        except (RuntimeError, OSError) as error:
            log.seek(0)
            missing = "dapter" in log.read()  # wgpu: no suitable adapter
            reason = _CURE if missing or not _drivers() else str(error).splitlines()[0]
            raise ValueError(f"{picture}: the headless viewer drew nothing: {reason}") from None
        finally:
            viewer.terminate()
            viewer.wait()
    try:
        picture.write_bytes(image)
    except OSError as error:
        raise ValueError(f"{picture}: cannot write: {error.strerror}") from None


def _picture(viewer: subprocess.Popen[bytes], port: int, at: float) -> bytes:
    """The PNG's bytes. Raises RuntimeError if the viewer does not answer or a view reports that it cannot draw."""
    deadline = time.monotonic() + _START
    while True:
        try:
            client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            state = client.get_state()
            if state.recordings and state.recordings[0].timelines and not state.loading:
                break
        except (RuntimeError, OSError) as error:
            if viewer.poll() is not None:
                raise RuntimeError(str(error) or "it ended") from None
        if time.monotonic() > deadline:
            raise RuntimeError(f"nothing to show after {_START:.0f} s")
        time.sleep(0.2)
    client.set_time(TIMELINE, duration=at, play_state="paused")
    time.sleep(_SETTLE)
    image = bytes(client.take_screenshot())
    for view in client.get_state().views:
        if view.reports:
            raise RuntimeError(f"view {view.name!r}: {view.reports[0]}")
    return image


def _drivers() -> list[Path]:
    return sorted(_SOFTWARE_DRIVERS.glob("lvp_icd*.json"))


def _environment(scratch: str) -> dict[str, str]:
    environment = {"XDG_RUNTIME_DIR": scratch, **os.environ}
    if _drivers() and "VK_ICD_FILENAMES" not in environment:
        environment["VK_ICD_FILENAMES"] = str(_drivers()[0])
    return environment


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def main(arguments: list[str] | None = None) -> int:
    """The command line; exit status."""
    parser = Parser(prog="testbed.recording.screenshot", description="Picture of a recording")
    parser.add_argument("recording", type=Path, help="an .rrd file")
    parser.add_argument("picture", type=Path, help="the .png to write")
    parser.add_argument("--time", type=float, help="where in the drive, in s (default: two thirds into it)")
    parser.add_argument("--size", default="1600x900", help="width x height in pixels (default 1600x900)")
    given = parser.parse_args(arguments)
    try:
        screenshot(given.recording, given.picture, given.time, given.size)
    except ValueError as error:
        print(f"testbed.recording.screenshot: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
