# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0
"""Where recordings are: paths, folders of them, patterns, and what fsspec reaches."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from glob import glob, has_magic
from pathlib import Path, PurePosixPath
import re
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from .joint_table import ENDINGS, JointTable, TableFormat
from .recording import ALLOWED, FORMATS, METADATA, Recording
from ..errors import optional_module, ToolError

_STORAGES = tuple(ending + more for ending in ('.mcap', '.db3') for more in ('', '.zstd'))
_RECORDINGS = (*(ending + more for ending in FORMATS for more in ('', '.zstd')), *ENDINGS)


class Source(NamedTuple):
    """A recording somewhere."""

    place: str    # path or URL
    name: str     # short and different from all others', for outputs
    size: int     # in bytes
    state: str    # changes when the recording changes


def find_sources(paths: Sequence[str]) -> list[Source]:
    """Return the recordings at paths: each a recording, a folder of them, or a pattern."""
    places: dict[str, tuple[int, str]] = {}
    for path in paths:
        found = dict(_remote(path) if '://' in path else _local(path))
        if not found:
            raise ToolError(f'{without_password(path)}: no recording there; allowed: {ALLOWED}, '
                            'and folders and patterns of these')
        places.update(found)
    names = short_names(list(places))
    return [Source(place, name, size, state)
            for (place, (size, state)), name in zip(places.items(), names)]


@contextmanager
def opened(place: str, table: TableFormat) -> Iterator[Recording | JointTable]:
    """Open a recording; one that is elsewhere is copied to a temporary folder."""
    if '://' in place:
        with TemporaryDirectory(prefix='screw_kinematics_') as folder:
            files, path = _filesystem(place)
            target = Path(folder, PurePosixPath(path).name)
            with _named(place):
                for file in files.find(path) if files.isdir(path) else [path]:
                    copy = target / PurePosixPath(file).relative_to(path)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    files.get_file(file, str(copy))
            with opened(str(target), table) as recording:
                yield recording
    elif _ends(place, ENDINGS):
        yield JointTable(Path(place), table)
    else:
        with Recording(Path(place)) as recording:
            yield recording


def group_files(files: Iterable[str]) -> dict[str, list[str]]:
    """
    Return the recordings among files, each with the files it is of.

    A folder with metadata, or with the numbered files of one bag and nothing else, is one
    recording; every other file is one by itself. Hidden folders and data sets are left out.

    Examples
    --------
    >>> sorted(group_files(['day/a.mcap', 'day/b.csv', 'day/run/run_0.db3', 'day/run/run_1.db3']))
    ['day/a.mcap', 'day/b.csv', 'day/run']

    """
    files = list(files)
    # A folder with records is one of outputs, unless recordings are asked for in it.
    outputs = {file.partition('/_done/')[0] + '/' for file in files if '/_done/' in file}
    folders: dict[str, list[str]] = {}
    for file in files:
        if any(file.startswith(output) for output in outputs):
            continue
        folder, _, name = file.rpartition('/')
        if not any(part.startswith(('.', '_')) or '=' in part for part in file.split('/')[1:]):
            folders.setdefault(folder, []).append(name)
    found: dict[str, list[str]] = {}
    for folder, names in sorted(folders.items()):
        recordings = sorted(name for name in names if _ends(name, _RECORDINGS))
        storages = [name for name in recordings if _ends(name, _STORAGES)]
        bag = storages == recordings and (_numbered(storages) or len(storages) == 1 and (
            _without_ending(storages[0]) == folder.rpartition('/')[2]))
        if METADATA in names or bag:
            found[folder] = [f'{folder}/{name}' for name in names]
        else:
            found.update({f'{folder}/{name}': [f'{folder}/{name}'] for name in recordings})
    return found


def short_names(places: Sequence[str]) -> list[str]:
    """
    Return a name for each place: what the paths do not have in common.

    Examples
    --------
    >>> short_names(['/data/mon/run.mcap', '/data/tue/run.mcap', '/data/tue/x.csv'])
    ['mon-run', 'tue-run', 'tue-x']

    """
    parts = [PurePosixPath(place).parts for place in places]
    common = 0 if len(places) > 1 else len(parts[0]) - 1
    while len(places) > 1 and len({part[common:common + 1] for part in parts}) == 1:
        common += 1
    common = min([common, *(len(part) - 1 for part in parts)])
    whole = ['-'.join(part[common:]) for part in parts]
    plain = [_without_ending(name) for name in whole]
    return [plain[i] if plain.count(plain[i]) == 1 else re.sub(r'[^\w-]', '_', whole[i])
            for i in range(len(places))]


def without_password(place: str) -> str:
    """
    Return a place as it may be shown.

    Examples
    --------
    >>> without_password('ssh://me:secret@host/day'), without_password('s3://lab/day')
    ('ssh://me:***@host/day', 's3://lab/day')

    """
    return re.sub('(://[^/:@]*:)[^/@]*@', r'\1***@', place)


def _local(path: str) -> Iterator[tuple[str, tuple[int, str]]]:
    given = [path] if Path(path).exists() or not has_magic(path) else sorted(
        glob(path, recursive=True))
    for each in map(Path, given):
        if each.is_file():
            groups = {str(each): [str(each)]} if _ends(each.name, _RECORDINGS) else {}
        else:
            groups = group_files(file.as_posix() for file in sorted(each.rglob('*'))
                                 if file.is_file() and file.parent != each / '_done')
            if len(groups) == 1 and _ends(next(iter(groups)), _STORAGES):
                groups = {str(each): next(iter(groups.values()))}     # a bag without metadata
        for place, files in groups.items():
            about = [Path(file).stat() for file in files]
            yield place, (sum(a.st_size for a in about), repr([
                (Path(f).name, a.st_size, a.st_mtime_ns) for f, a in zip(files, about)]))


def _remote(url: str) -> Iterator[tuple[str, tuple[int, str]]]:
    files, path = _filesystem(url)
    before = url.removesuffix(path) if url.endswith(path) else url.partition('://')[0] + '://'
    with _named(url):
        for each in sorted(files.glob(path)) if has_magic(path) else [path]:
            groups = group_files(sorted(files.find(each))) if files.isdir(each) else (
                {each: [each]})
            for place, parts in groups.items():
                about = [files.info(part) for part in parts]
                when = [str(a.get('ETag') or a.get('mtime') or a.get('LastModified'))
                        for a in about]
                yield before + place, (
                    sum(int(a['size'] or 0) for a in about), repr(list(zip(parts, when))))


def _filesystem(url: str) -> tuple[Any, str]:
    core = optional_module('fsspec.core', 'fleet', f'reading {without_password(url)}')
    with _named(url):
        files, path = core.url_to_fs(url)
    return files, str(path)


@contextmanager
def _named(url: str) -> Iterator[None]:
    """Turn what goes wrong at a place into one line that names it."""
    try:
        yield
    except Exception as error:      # each file system has errors of its own
        what = ' '.join(str(error).split())
        kind = '' if isinstance(error, (ImportError, ValueError)) and what else (
            f'{type(error).__name__}: ')
        raise ToolError(f'{without_password(url)}: {kind}{what}') from None


def _numbered(names: Sequence[str]) -> bool:
    """Return whether files are named as the parts of one bag: from 0 on, without a hole."""
    for pattern in (r'(.+)_(\d+)', r'(\d+)_(.+?)(?:_\d+.*)?'):
        parts = [re.fullmatch(pattern, _without_ending(name)) for name in names]
        which = 2 if pattern.startswith('(.') else 1
        if parts and all(parts):
            numbers = sorted(int(part[which]) for part in parts if part)
            prefixes = {part[3 - which] for part in parts if part}
            if len(prefixes) == 1 and numbers == list(range(len(numbers))):
                return True
    return False


def _ends(name: str, endings: tuple[str, ...]) -> bool:
    """Return whether a name has one of the endings, in capitals or not."""
    return name.lower().endswith(endings)


def _without_ending(name: str) -> str:
    return name[:len(name) - max(len(e) for e in ('', *_RECORDINGS) if _ends(name, (e,)))]
