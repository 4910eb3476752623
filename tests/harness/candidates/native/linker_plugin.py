"""A manifest whose flags have the linker run a plugin, which leaves a link to a file of the user's."""

from __future__ import annotations

import subprocess
from pathlib import Path

# A plugin of the linker: when that ends, it puts links next to its output, or in the output's place.
PLUGIN = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
static void leave(void) {
    static char words[65536], name[4096];
    FILE *file = fopen("/proc/self/cmdline", "r");
    size_t size = fread(words, 1, sizeof words - 1, file);
    const char *output = 0;
    for (char *word = words; word < words + size; word += strlen(word) + 1)
        if (!strcmp(word, "-o")) output = word + 3;
    strcpy(name, output);
    if (strcmp(NAME, "library.so")) strcpy(strrchr(name, '/') + 1, NAME);
    else unlink(name);
    if (symlink(SECRET, name)) perror("symlink");
}
__attribute__((constructor)) static void begin(void) { atexit(leave); }
int onload(void *vector) { return vector == 0; }
"""


def manifest(folder: Path, flags: str = "") -> str:
    file = folder / "candidate.toml"
    file.write_text(f'schema = 1\nname = "mine"\nkind = "c"\nentry = "mine.c"\nflags = [{flags}]\n')
    return str(file)


def with_plugin(folder: Path, name: str, secret: Path) -> str:
    """Write a manifest whose flags have the linker leave a link with a name."""
    (folder / "plugin.c").write_text(PLUGIN, encoding="utf-8")
    defined = [f'-DNAME="{name}"', f'-DSECRET="{secret}"']
    words = ["cc", "-shared", "-fPIC", *defined, "-o", str(folder / "plugin.so"), str(folder / "plugin.c")]
    subprocess.run(words, check=True)
    return manifest(folder, '"-Xlinker", "-plugin=./plugin.so"')
