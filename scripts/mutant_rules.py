"""The single changes that scripts/mutants makes to a C++ source: each one is a mistake that a test must find."""
import dataclasses
import re

SWAPS = {
    " < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == ",
    " && ": " || ", " || ": " && ", " + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " % ": " * ",
    " & ": " | ", " | ": " & ", " |= ": " &= ", " &= ": " |= ", " += ": " -= ", " -= ": " += ", "++": "--", "--": "++",
}
WORDS = {
    "true": "false", "false": "true", "std::abs": "", "std::min": "std::max", "std::max": "std::min",
    "std::ceil": "std::floor", "std::floor": "std::ceil",
}
SWAP = re.compile("|".join(re.escape(swap) for swap in sorted(SWAPS, key=len, reverse=True)))
WORD = re.compile(r"(?<![\w:])(?:" + "|".join(WORDS) + r")(?![\w<])")
NOT = re.compile(r"(?<![\w!])!(?=[\w(])")
NUMBER = re.compile(r"(?<![\w.])(0x[0-9A-Fa-f]+|\d[\d']*(?:\.\d+)?(?:e[+-]?\d+)?)([uUlLfF]*)(?![\w.])")
# A condition negated by another rule.
SIMPLE = re.compile(r"![\w.()*]+|(?:(?! && | \|\| | == | != ).)*(?: == | != )(?:(?! && | \|\| ).)*", re.DOTALL)
IF = re.compile(r"\bif \(")
CLAMP = re.compile(r"\bstd::clamp\(")
QUESTION = re.compile(r" \? ")
RETURN = re.compile(r"\breturn ([^;{}]*(?: [<>=!]=? | && | \|\| |==)[^;{}]*);")
# An assignment or a call at the start of a statement; a declaration has a name after its type and does not match.
STATEMENT = re.compile(r"(?:(?<=\n)[ ]+|(?<=\{ ))(?!return\b|if\b|for\b|while\b|switch\b|case\b|else\b)"
                       r"(?=(?:\+\+|--)?[\w:.\->]+(?:\[[^\]]*\])?(?:\(| = | [-+|&]= |\+\+|--|;))")
UNREAD = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^#[^\n]*', re.MULTILINE)
OPENING, CLOSING = "([{", ")]}"


@dataclasses.dataclass(frozen=True)
class Mutant:
    """Replaces text[begin:end] of a file."""
    file: str
    text: str
    begin: int
    end: int
    replacement: str

    @property
    def mutated(self):
        return self.text[:self.begin] + self.replacement + self.text[self.end:]

    @property
    def lines(self):
        """Returns the changed lines of the file, counted from 1."""
        return range(self.text.count("\n", 0, self.begin) + 1, self.text.count("\n", 0, self.end) + 2)

    @property
    def key(self):
        """File, changed lines before and after: identifies the mutant even if other lines have moved."""
        first = self.text.rfind("\n", 0, self.begin) + 1
        last = self.text.find("\n", self.end)
        before = self.text[first:last]
        after = self.text[first:self.begin] + self.replacement + self.text[self.end:last]
        return self.file, " ".join(before.split()), " ".join(after.split())


def mutants_of(file, text):
    """Yields every mutant of a source; for a header, those of its one-line functions."""
    code = UNREAD.sub(lambda found: " " * len(found[0]), text)
    found = {(begin, end, replacement) for rule in RULES for begin, end, replacement in rule(code)}
    mutants = [Mutant(file, text, *place) for place in sorted(found) if text[place[0]:place[1]] != place[2]]
    if not file.endswith(".h"):
        return mutants
    return [mutant for mutant in mutants if re.search(r"\)[^;]* \{.*\}$", mutant.key[1])]


def end_of(code, begin, stop):
    """Returns the index of the first of the characters `stop` outside brackets opened after `begin`; None if missing."""
    depth = 0
    for index in range(begin, len(code)):
        if depth == 0 and code[index] in stop:
            return index
        depth += (code[index] in OPENING) - (code[index] in CLOSING)
        if depth < 0:
            return None
    return None


def swapped_operators(code):
    return [(found.start(), found.end(), SWAPS[found[0]]) for found in SWAP.finditer(code)]


def swapped_words(code):
    return [(found.start(), found.end(), WORDS[found[0]]) for found in WORD.finditer(code)]


def dropped_negations(code):
    return [(found.start(), found.end(), "") for found in NOT.finditer(code)]


def changed_constants(code):
    """Changes a whole number by one, another number by a fifth."""
    for found in NUMBER.finditer(code):
        number, suffix = found[1].replace("'", ""), found[2]
        if number.startswith("0x") or number.isdigit():
            value = int(number, 0) if number.startswith("0x") else int(number)
            others = [value + 1, value - 1] if value > 0 else [1]
        else:
            value = float(number)
            step = 1.0 if value.is_integer() else 0.2 * value
            others = [f"{value + step:.12g}", f"{value - step:.12g}"] if value else ["1"]
            others = [other if "e" in other or "." in other else other + ".0" for other in others]
        for other in others:
            yield found.start(), found.end(), f"{other}{suffix}"


def changed_conditions(code):
    """Negates the condition of an `if`, and makes it always false."""
    for found in IF.finditer(code):
        end = end_of(code, found.end(), ")")
        begin = end_of(code, found.end(), ";)")
        begin = found.end() if begin == end else begin + 2
        if SIMPLE.fullmatch(code[begin:end]) is None:
            yield begin, end, f"!({code[begin:end]})"
        yield begin, end, "false"


def negated_returns(code):
    return [(found.start(1), found.end(1), f"!({found[1]})") for found in RETURN.finditer(code)]


def swapped_choices(code):
    """`c ? a : b` becomes `c ? b : a`."""
    for found in QUESTION.finditer(code):
        colon = code.find(" : ", found.end())
        end = end_of(code, found.end(), ";),")
        if colon < 0 or end is None or colon > end:
            continue
        first, second = code[found.end():colon], code[colon + 3:end]
        if "?" not in first + second:
            yield found.end(), end, f"{second} : {first}"


def dropped_bounds(code):
    """`std::clamp(x, lo, hi)` without its upper, then without its lower bound."""
    for found in CLAMP.finditer(code):
        first = end_of(code, found.end(), ",")
        second = end_of(code, first + 1, ",")
        end = end_of(code, second + 1, ")")
        value, low, high = code[found.end():first], code[first + 1:second], code[second + 1:end]
        yield found.start(), end + 1, f"std::max({value},{low})"
        yield found.start(), end + 1, f"std::min({value},{high})"


def removed_statements(code):
    for found in STATEMENT.finditer(code):
        end = end_of(code, found.end(), ";,{")
        if end is not None and code[end] == ";":
            yield found.end(), end + 1, ";"


RULES = (swapped_operators, swapped_words, dropped_negations, changed_constants, changed_conditions, negated_returns,
         swapped_choices, dropped_bounds, removed_statements)
