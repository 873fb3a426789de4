"""Every example in a docstring of the package gives the stated result; every public class and function has a docstring."""
import doctest
import inspect
import sys

import hystcan


def documented():
    yield "hystcan", hystcan.__doc__
    for name in hystcan.__all__:
        thing = getattr(hystcan, name)
        if not (inspect.isclass(thing) or callable(thing)):
            continue
        yield name, thing.__doc__
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            yield f"{name}.{member}", getattr(getattr(value, "__func__", value), "__doc__", None)


runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
lacking = []
for name, text in documented():
    if not text and not name.split(".")[-1].startswith("_"):
        lacking.append(name)
    if text and ">>>" in text:
        names = {"hystcan": hystcan, "Client": hystcan.Client}
        runner.run(doctest.DocTestParser().get_doctest(text, names, name, None, 0))
failed, tried = runner.summarize()
if lacking:
    print("no docstring:", *lacking)
print(f"{tried} examples")
sys.exit(bool(failed or lacking or not tried))
