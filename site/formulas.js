// Sets the formulas of a page, which pymdownx.arithmatex leaves as \(...\) and \[...\].
for (const formula of document.querySelectorAll('.arithmatex'))
  katex.render(formula.textContent.slice(2, -2), formula, { displayMode: formula.tagName === 'DIV' });
