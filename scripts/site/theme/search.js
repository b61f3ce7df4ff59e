// SPDX-License-Identifier: Apache-2.0
// Lists the sections of all pages that hold every word of the question, or words that contain it. searchIndex is of
// search/search_index.js, which also a page that is opened as a file may load.
'use strict';
const field = document.querySelector('header input');
const question = new URLSearchParams(location.search).get('q') || '';
const words = question.toLowerCase().split(/\s+/).filter((word) => word);
field.value = question;

const occurrences = (text, word) => text.split(word).length - 1;

/** How well a section answers: 0 where a word is missing; a word of its heading counts most, and of a text its share. */
function worth(section) {
  const title = section.title.toLowerCase(), text = section.text.toLowerCase();
  const of = words.map((word) => occurrences(title, word) + 100 * occurrences(text, word) / (500 + text.length));
  return of.includes(0) ? 0 : of.reduce((sum, one) => sum + one, 0);
}

/** The sections that answer, the best first. */
const answers = (sections) => sections.map((section) => [worth(section), section]).filter(([value]) => value > 0)
  .sort((a, b) => b[0] - a[0]);

/** The text around the first word, all words of the question marked. */
function excerpt(text) {
  const places = words.map((word) => text.toLowerCase().indexOf(word)).filter((at) => at >= 0), first = Math.min(text.length, ...places);
  const start = first < 80 || !places.length ? 0 : text.indexOf(' ', first - 80) + 1, part = text.slice(start, start + 240);
  const line = document.createElement('p');
  const escaped = words.map((word) => word.replace(/[.*+?^${}()|[\]\\]/g, '\\$&'));
  for (const [k, piece] of part.split(new RegExp(`(${escaped.join('|')})`, 'i')).entries()) {
    const mark = document.createElement(k % 2 ? 'mark' : 'span');
    mark.textContent = piece;
    line.append(mark);
  }
  return line;
}

const isPage = (doc) => !doc.location.includes('#');
const titles = new Map(searchIndex.docs.filter(isPage).map((doc) => [doc.location, doc.title.replaceAll('`', '')]));
let found = words.length ? answers(searchIndex.docs.filter((doc) => !isPage(doc))) : [];
// Words that no section has together may stand in one page.
if (words.length && !found.length) found = answers(searchIndex.docs.filter(isPage));
for (const [, section] of found.slice(0, 50)) {
  const link = document.createElement('a'), entry = document.createElement('li');
  const page = titles.get(section.location.split('#')[0]), title = section.title.replaceAll('`', '');
  link.href = section.location;
  link.textContent = page && page !== title ? `${page}: ${title}` : title;
  entry.append(link, excerpt(section.text));
  document.getElementById('results').append(entry);
}
document.getElementById('found').textContent = !words.length ? 'Write a word into the field above.'
  : !found.length ? `No page has all of: ${question}`
  : `${found.length} ${found.length === 1 ? 'place' : 'places'} for: ${question}` + (found.length > 50 ? ' (the best 50)' : '');
