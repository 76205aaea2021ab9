"""A whole session by keyboard, as an experimenter does it: in tmux, over ssh, at 80 × 24 and at 40 × 10 cells; in the small window the
participant answers at a screen of their own beside it.

    python terminal.py --zwidth PROGRAM --out FOLDER

needs tmux and OpenSSH's client and server; keeps each phase's screen in FOLDER as text. The simulated device, in real time.
"""

import argparse
import getpass
import json
import os
import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

LONGEST_S = 60
SIZES = [(80, 24), (40, 10)]


def run(*command, **more):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, **more).stdout


class Host:
    """An ssh server of this user's own, which lets this user in by a key of its own."""

    def __init__(self, folder):
        self.folder = folder
        for name in ("host", "user"):
            run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / name)
        shutil.copy(folder / "user.pub", folder / "authorized")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        settings = {
            "Port": self.port,
            "ListenAddress": "127.0.0.1",
            "HostKey": folder / "host",
            "AuthorizedKeysFile": folder / "authorized",
            "PidFile": folder / "pid",
            "StrictModes": "no",
            "UsePAM": "no",
        }
        (folder / "settings").write_text("".join(f"{name} {value}\n" for name, value in settings.items()))
        if os.geteuid() == 0:
            Path("/run/sshd").mkdir(exist_ok=True)
        self.server = subprocess.Popen([shutil.which("sshd") or "/usr/sbin/sshd", "-D", "-e", "-f", folder / "settings"], stderr=subprocess.DEVNULL)

    def command(self, words):
        known = ["-o", "StrictHostKeyChecking=no", "-o", f"UserKnownHostsFile={self.folder / 'known'}", "-o", "LogLevel=ERROR", "-o", "ConnectionAttempts=20"]
        return ["ssh", "-tt", "-i", self.folder / "user", "-p", self.port, *known, f"{getpass.getuser()}@127.0.0.1", *words]


class Window:
    """A terminal of so many cells that runs a command; what is on it is read, and keys are pressed."""

    def __init__(self, name, size, command):
        self.tmux = ["tmux", "-L", f"zwidth-{os.getpid()}-{name}", "-f", "/dev/null"]
        width, height = size
        # The last screen of a program that has ended is still there to be read.
        run(*self.tmux, "new-session", "-d", "-x", width, "-y", height, "sleep", LONGEST_S * 60)
        run(*self.tmux, "set-option", "-g", "remain-on-exit", "on")
        run(*self.tmux, "set-option", "-g", "status", "off")
        run(*self.tmux, "respawn-pane", "-k", *command)

    def screen(self):
        return run(*self.tmux, "capture-pane", "-p").rstrip("\n")

    def press(self, *keys):
        run(*self.tmux, "send-keys", *keys)

    def type(self, text):
        run(*self.tmux, "send-keys", "-l", text)
        self.press("Enter")

    def until(self, *words):
        """Waits until one of these is on the screen; the screen, and which."""
        end = time.monotonic() + LONGEST_S
        while time.monotonic() < end:
            screen = self.screen()
            found = [word for word in words if word in screen]
            if found:
                return screen, found[0]
            time.sleep(0.05)
        raise SystemExit(f"none of {words} came within {LONGEST_S} s; there is:\n{self.screen()}")

    def ended(self):
        """Waits until the command has ended."""
        end = time.monotonic() + LONGEST_S
        while run(*self.tmux, "display-message", "-p", "#{pane_dead}").strip() != "1":
            if time.monotonic() > end:
                raise SystemExit(f"it did not end within {LONGEST_S} s; there is:\n{self.screen()}")
            time.sleep(0.05)

    def close(self):
        subprocess.run([*self.tmux, "kill-server"], capture_output=True)


class Session:
    """A study of six conditions, once each, and its session at a window of one size."""

    def __init__(self, zwidth, host, size, out):
        self.zwidth, self.host, self.size, self.out = zwidth, host, size, out
        self.root = Path(tempfile.mkdtemp(dir=host.folder))
        run(zwidth, "--root", self.root, "new", "pilot")
        study = self.root / "raw/pilot/study.toml"
        text = study.read_text()
        for before, after in [("\nrepeats = 6\n", "\nrepeats = 1\n"), ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"), ("\npause_s = 5.0\n", "\npause_s = 2.0\n"), ("\nrate_hz = 1000.0\n", "\nrate_hz = 200.0\n")]:
            assert before in text, before
            text = text.replace(before, after)
        study.write_text(text)

    def open(self, name, *words):
        return Window(name, self.size, self.host.command([str(self.zwidth), "--root", str(self.root), *words]))

    def acquire(self, name):
        return self.open(name, "acquire", "pilot", "-p", "P01", "-s", "S01", "--by", "E1")

    def keep(self, name, screen):
        width, height = self.size
        (self.out / f"{width}x{height}-{name}.txt").write_text(screen + "\n")

    def trial(self, window, answers, key="4"):
        """Starts the trial that is ready, and answers its question at that window. Where the machine stood still for so long that safety
        stopped the trial, it is done again."""
        while True:
            window.until("READY")
            window.press("Enter")
            screen, _ = window.until("TRIAL", "STOPPED")
            self.keep("trial", screen)
            screen, which = window.until("QUESTION", "STOPPED")
            if which == "QUESTION":
                break
            window.press("Enter")
        self.keep("question", screen)
        if answers is not window:
            screen, _ = answers.until("strongly disagree")
            self.keep("participant-question", screen)
        answers.press(key)
        screen, _ = window.until("PAUSE", "READY", "DONE")
        self.keep("pause", screen)

    def listed(self):
        return json.loads(run(self.zwidth, "--root", self.root, "--json", "list", "pilot"))[0]["sessions"][0]


def whole(session, beside):
    """The session: answers, a remark, an exclusion and a repeat of any trial, the stop key, an end in the middle and the way on."""
    window = session.acquire("first")
    screen, _ = window.until("READY")
    session.keep("ready", screen)
    answers = window
    if beside:
        answers = session.open("participant", "participant", "pilot")
        screen, _ = answers.until("practice")
        session.keep("participant-ready", screen)
    session.trial(window, answers)
    session.trial(window, answers, "5")
    window.press("n")
    screen, _ = window.until("remark", "note", "Note")
    session.keep("note", screen)
    window.type("slowly")
    session.trial(window, answers, "2")
    window.until("READY")
    window.press("t")
    window.type("2")
    window.press("x")
    window.type("the phone rang")
    window.until("READY")
    window.press("Enter")
    window.until("TRIAL")
    window.press("Space")
    screen, _ = window.until("STOPPED")
    session.keep("stopped", screen)
    window.press("q")
    window.press("y")
    window.ended()
    window.close()
    if beside:
        answers.ended()
        answers.close()
    window = answers = session.acquire("second")
    if beside:
        window.until("READY")
        answers = session.open("participant-again", "participant", "pilot")
    while True:
        _, which = window.until("READY", "DONE")
        if which == "DONE":
            break
        session.trial(window, answers, "3")
    screen = window.screen()
    session.keep("done", screen)
    window.press("q")
    window.press("y")
    window.ended()
    for one in {id(window): window, id(answers): answers}.values():
        one.close()


def judged(session):
    listed = session.listed()
    assert listed["trials_that_count"] == 6 and listed["to_go"] == 0, listed
    run(session.zwidth, "--root", session.root, "verify", "pilot")
    log = (session.root / "raw/pilot/sessions/P01_S01.events.jsonl").read_text()
    events = [json.loads(line) for line in log.splitlines()]
    of = lambda event: [line["what"] for line in events if line["what"]["event"] == event]
    notes = [note["text"] for note in of("note")]
    assert "slowly" in notes, notes
    assert {"event": "excluded", "trial": 2, "reason": "the phone rang"} in of("excluded"), of("excluded")
    assert all(line.get("by") == "E1" for line in events if line["what"]["event"] in ("excluded", "answer")), events
    return len(of("recorded")), len(of("answer"))


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--zwidth", required=True, type=Path)
    arguments.add_argument("--out", required=True, type=Path)
    given = arguments.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        host = Host(Path(folder))
        try:
            for size in SIZES:
                session = Session(given.zwidth.resolve(), host, size, given.out)
                beside = size == SIZES[-1]
                whole(session, beside)
                trials, answers = judged(session)
                where = "at the participant's own screen" if beside else "at the same screen"
                print(f"{size[0]} × {size[1]}: a whole session by keyboard over ssh: {trials} trials recorded, {answers} answers given {where}")
        finally:
            host.server.terminate()


if __name__ == "__main__":
    main()
