// Building and changing elements. Text of the server goes in as text, never as markup.

export const byId = (id) => document.getElementById(id);

/** An element with properties (`class`, `text`, `aria-...`, functions for events as `onclick`) and children. */
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

/** Changes the text only where it is another one: screen readers then announce only what is new. */
export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

/** As setText(). A path in the text breaks behind its slashes; a name in it breaks only if it is longer than a line. */
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

/** Gives the browser a file to store. */
export function download(name, content) {
  const link = element('a', { href: URL.createObjectURL(content), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Opens a dialog below the bar, which leaves the page in use: Stop must always be within reach of the pointer. */
export function openDialog(id) {
  const dialog = byId(id);
  if (!dialog.open) dialog.show();
  dialog.querySelector('input, button').focus();
}

/** A place for the answer to what the user has asked for, and the answer in it. */
export const answerPlace = () => element('p', { class: 'answer', role: 'status' });

export function tell(place, answer, done) {
  place.className = `answer ${answer.ok ? 'done' : 'refused'}`;
  setText(place, answer.ok ? done : (answer.error ?? 'refused'));
}

/** The rows of a table: a name and its values each. */
export function fillTable(body, rows) {
  while (body.rows.length > rows.length) body.lastElementChild.remove();
  while (body.rows.length < rows.length)
    body.append(
      element('tr', {}, element('th', { scope: 'row' }), ...rows[0].slice(1).map(() => element('td'))),
    );
  rows.forEach((texts, row) => texts.forEach((text, cell) => setText(body.rows[row].cells[cell], String(text))));
}
