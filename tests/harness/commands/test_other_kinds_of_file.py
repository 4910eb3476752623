"""A file of another kind than a command reads is called by what it is."""

import pytest

FILES = {
    "candidate.toml": 'schema = 1\nname = "mine"\nkind = "c"\nentry = "controller.c"\n',
    "waivers.toml": 'schema = 1\n[[waiver]]\ncheck = "STP-1"\n',
    "campaign.toml": 'schema = 1\nname = "x"\ncandidates = ["foc"]\n',
}


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            "check foc --drive candidate.toml",
            "candidate.toml is the manifest of a candidate, as its key 'entry' shows, but the file of a drive is",
        ),
        (
            "simulate foc --case waivers.toml",
            "waivers.toml is a file of waivers, as its key 'waiver' shows, but a",
        ),
        ("campaign candidate.toml", "candidate.toml is the manifest of a candidate"),
        (
            "check campaign.toml",
            "campaign.toml is a campaign, as its key 'candidates' shows, but the manifest of",
        ),
        ("check foc --waivers candidate.toml", "but a file of waivers is required here"),
    ],
)
def test_it_is_called_by_what_it_is(command, tmp_path, monkeypatch, words, sentence):
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    ended = command(*words.split())
    assert ended.code == 2
    assert sentence in ended.err
