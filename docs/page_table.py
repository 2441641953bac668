"""Where a script puts its table in a page of the docs: between two comments, which stay."""


def write_table(page, begin, end, lines):
    before, rest = page.read_text(encoding="utf-8").split(begin)
    page.write_text(before + begin + "".join(lines) + end + rest.split(end)[1], encoding="utf-8")
