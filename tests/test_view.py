"""`handgen view`: what it serves, to whom, and how it follows the file."""

import http.client
import json
import threading
from pathlib import Path

import pytest

from handgen import cli
from handgen.errors import EngineError, InputError
from handgen.parameters.load import load
from handgen.report import view
from handgen.report.write import Report
from tests.strategies import PARAMS

PATIENCE = 60
"""Seconds after which something hangs, on however busy a machine."""


@pytest.fixture
def composed(monkeypatch):
    """Pages at once: the real reading of the file, then a word of it; (file, known) of every call."""
    calls = []

    def compose(params, out, *, workers, progress, known, serial):
        hand = load(params).hand
        progress("bending index")
        calls.append((Path(params).name, known))
        missing = {"index": "not solved yet"} if known else {}
        return Report(hand.name, f"{serial}: {hand.description}".encode(), True, 0, {}, missing)

    monkeypatch.setattr(view, "compose", compose)
    return calls


@pytest.fixture
def file(tmp_path):
    (tmp_path / "base.yaml").write_text((PARAMS / "thesis_finger.yaml").read_text())
    return written(tmp_path / "mine.yaml", "first")


def written(path, description):
    path.write_text(f"schema: handgen.hand/1\nextends: base.yaml\nname: mine\ndescription: {description}\n")
    return path


@pytest.fixture
def maker(file, composed, tmp_path):
    return view.Maker(file, tmp_path / "out")


@pytest.fixture
def server(maker, tmp_path):
    """Serving, without a follower."""
    folder = tmp_path / "out"
    (folder / "exoskeleton").mkdir(parents=True)
    (folder / "exoskeleton/index.stl").write_bytes(b"solid")
    (folder / ".hidden").write_text("secret")
    (tmp_path / "secret.txt").write_text("secret")
    (folder / "link").symlink_to(tmp_path / "secret.txt")
    (folder / "out").symlink_to(tmp_path)
    with view.Server(maker, 0) as found:
        thread = threading.Thread(target=found.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        yield found
        found.shutdown()


def asked(server, target, host=None, method="GET"):
    """(status, headers, content); the target goes out as it stands."""
    connection = http.client.HTTPConnection(view.HOST, server.server_port, timeout=PATIENCE)
    connection.putrequest(method, target, skip_host=True)
    connection.putheader("Host", host if host is not None else f"{view.HOST}:{server.server_port}")
    connection.endheaders()
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer.status, answer.headers, content


def test_listens_on_this_machine_only(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"


def test_serves_page_state_and_files_of_the_folder(server, maker):
    maker.make()
    assert asked(server, "/")[2] == b"2: first"
    assert json.loads(asked(server, "/state")[2]) == {"serial": 2, "busy": "", "problems": []}
    status, headers, content = asked(server, "/exoskeleton/index.stl")
    assert (status, content) == (200, b"solid")
    assert headers["X-Content-Type-Options"] == "nosniff" and "default-src 'none'" in headers[
        "Content-Security-Policy"]
    assert asked(server, "/", method="HEAD")[2] == b""


@pytest.mark.parametrize("target", [
    "/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/%2e%2e%2fsecret.txt",
    "/exoskeleton/../../secret.txt", "/exoskeleton/%2e%2e/%2e%2e/secret.txt", "//etc/passwd",
    "/%2fetc/passwd", "/etc/passwd", "/link", "/out/secret.txt", "/.hidden", "/%2ehidden", "/..\\secret.txt",
    "/%5c..%5csecret.txt", "/link%00", "/%252e%252e/secret.txt", "/exoskeleton", "/exoskeleton/",
    "http://elsewhere/../secret.txt"])
def test_nothing_outside_the_folder(server, target):
    status, _, content = asked(server, target)
    assert (status, content) == (404, b"not here")


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{port}", "127.0.0.1", "", "[::1]:{port}"])
def test_a_page_under_another_name_reads_nothing(server, host):
    assert asked(server, "/", host.format(port=server.server_port))[0] == 403


def test_nothing_is_taken(server):
    assert asked(server, "/", method="POST")[0] == 501


def test_a_reader_that_leaves_is_no_news(server, capsys):
    def failing(error):
        try:
            raise error
        except OSError:
            server.handle_error(None, (view.HOST, 1))
        return capsys.readouterr().err

    assert failing(ConnectionResetError()) == failing(BrokenPipeError()) == ""
    assert "OSError" in failing(OSError())


def test_a_page_with_what_is_known_comes_first(maker, composed):
    maker.make()
    assert composed == [("mine.yaml", True), ("mine.yaml", False)]
    assert maker.state == {"serial": 2, "busy": "", "problems": []}


def test_a_save_ends_the_bending_for_the_page_before(maker, composed):
    maker.make(lambda: True)
    assert composed == [("mine.yaml", True)]
    assert maker.state == {"serial": 1, "busy": "", "problems": []}


def test_errors_leave_the_last_good_page_and_the_next_save_mends(maker, file):
    maker.make()
    good = maker.page
    file.write_text(file.read_text() + "finger: 1\nthread: {diameter: -1}\n")
    maker.make()
    assert maker.page == good and maker.serial == 2
    assert len(maker.problems) == 2 and "finger" in maker.problems[0] and "diameter" in maker.problems[1]
    file.write_text("extends: [")
    maker.make()
    assert maker.page == good and "not valid YAML" in maker.problems[0]
    written(file, "second")
    maker.make()
    assert (maker.page, maker.problems) == (b"4: second", [])


@pytest.mark.parametrize(("error", "words"), [
    (EngineError("the solver gave up"), "the solver gave up"), (OSError(28, "no space"), "no space"),
    (ZeroDivisionError("oh"), "mistake in handgen itself")])
def test_whatever_goes_wrong_the_next_save_gets_its_page(maker, file, monkeypatch, error, words, capfd):
    def fails(*_, **__):
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(view, "compose", fails)
        maker.make()
    assert words in maker.problems[0]
    maker.make()
    assert (maker.serial, maker.problems) == (2, [])


def test_stamps_know_the_file_and_all_that_it_extends(file, tmp_path):
    seen = view.stamps(file)
    assert [Path(path).name for path, *_ in seen] == ["mine.yaml", "base.yaml"]
    base = tmp_path / "base.yaml"
    base.write_text(base.read_text() + "# a word\n")
    assert view.stamps(file) != seen
    base.unlink()
    assert len(view.stamps(file)) == 1
    assert view.stamps(tmp_path / "none.yaml") == []


def test_follows_saves_of_the_base_and_ends(maker, tmp_path, monkeypatch):
    monkeypatch.setattr(view, "EVERY", 0.01)
    ended, page = threading.Event(), threading.Event()
    maker.say = lambda line: page.set()
    thread = threading.Thread(target=maker.follow, args=(ended,))
    thread.start()
    try:
        assert page.wait(PATIENCE)
        while maker.busy or maker.serial < 2:
            assert thread.is_alive()
        page.clear()
        base = tmp_path / "base.yaml"
        base.write_text(base.read_text() + "# a word\n")
        assert page.wait(PATIENCE)
    finally:
        ended.set()
        thread.join(PATIENCE)
    assert not thread.is_alive()


def test_a_taken_port_is_bad_input(server, maker, file, capsys):
    with pytest.raises(InputError) as caught:
        view.Server(maker, server.server_port)
    [problem] = caught.value.problems
    assert (problem.path, problem.value) == ("--port", server.server_port)
    assert cli.main(["view", str(file), "--port", str(server.server_port)]) == 2
    assert "a free port" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_bad_input(tmp_path, capsys):
    assert cli.main(["view", str(tmp_path / "none.yaml"), "--port", "0"]) == 2
    assert "no such file" in capsys.readouterr().err


def test_an_interrupt_ends_it_cleanly(file, composed, monkeypatch, capsys):
    def interrupted(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(view.Server, "serve_forever", interrupted)
    assert cli.main(["view", str(file), "--port", "0"]) == 0
    assert f"http://{view.HOST}:" in capsys.readouterr().err
