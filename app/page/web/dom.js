// Creates and changes elements. Text from the server is inserted as text, never as markup.

export const byId = (id) => document.getElementById(id);

/** Creates an element with properties (`class`, `text`, `aria-...`, event functions such as `onclick`) and children. */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'text') made.textContent = value;
    else if (typeof value === 'function') made.addEventListener(name.slice(2), value);
    else made.setAttribute(name === 'class' ? 'class' : name, value === true ? '' : value);
  }
  made.append(...children);
  return made;
}

/** Sets the text only if it differs, so that screen readers announce only changes. */
export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

/** Like setText(). A path wraps after slashes; a name in it wraps only if it is longer than a line. */
export function setTextWithPath(target, text) {
  if (target.textContent === text) return;
  const pieces = (word) =>
    word.includes('/') ? word.split(/(?<=\/)/).map((piece) => element('span', { class: 'piece', text: piece })) : [word];
  target.replaceChildren(...text.split(/(\s+)/).flatMap(pieces));
}

export function setOptions(select, options) {
  const chosen = select.value;
  select.replaceChildren(...options.map(([value, text]) => element('option', { value, text })));
  if (options.some(([value]) => String(value) === chosen)) select.value = chosen;
}

/** Lets the browser download a file. */
export function download(name, content) {
  const link = element('a', { href: URL.createObjectURL(content), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Opens a dialog below the bar. The page stays usable, because the pointer must always reach Stop. */
export function openDialog(id) {
  const dialog = byId(id);
  if (!dialog.open) dialog.show();
  dialog.querySelector('input, button').focus();
}

/** Creates a place for the answer to a user's request, and shows the answer in it. */
export const answerPlace = () => element('p', { class: 'answer', role: 'status' });

export function tell(place, answer, done) {
  place.className = `answer ${answer.ok ? 'done' : 'refused'}`;
  setText(place, answer.ok ? done : (answer.error ?? 'refused'));
}

/** Fills a table with rows of a name and its values. */
export function fillTable(body, rows) {
  while (body.rows.length > rows.length) body.lastElementChild.remove();
  while (body.rows.length < rows.length)
    body.append(
      element('tr', {}, element('th', { scope: 'row' }), ...rows[0].slice(1).map(() => element('td'))),
    );
  rows.forEach((texts, row) => texts.forEach((text, cell) => setText(body.rows[row].cells[cell], String(text))));
}
