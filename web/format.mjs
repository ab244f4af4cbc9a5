// SPDX-License-Identifier: Apache-2.0
// Numbers and times as people read them. What is not known is a dash.

export const UNKNOWN = "–";

/** How each language writes dates; with English they are as Europe writes them. */
const LOCALES = { en: "en-GB", de: "de-DE" };
let language = "en";
let separator = "."; // of decimals

/** From now on dates and numbers are written as in that language: a key of LOCALES. */
export function speak(tag) {
  language = tag;
  separator = new Intl.NumberFormat(LOCALES[tag]).formatToParts(0.5).find(({ type }) => type === "decimal").value;
}

/** The form that goes with a count: `forms` by the categories of Intl.PluralRules. */
export const plural = (count, forms) => forms[new Intl.PluralRules(LOCALES[language]).select(count)] ?? forms.other;

/** Digits as JavaScript writes them, with the decimal separator and minus sign of people. */
export const written = (digits) => digits.replace(".", separator).replace("-", "−");

/** A number with so many decimals and a true minus sign. */
export function number(value, decimals) {
  if (value === null || value === undefined) return UNKNOWN;
  const text = value.toFixed(decimals);
  return written(Number(text) === 0 ? text.replace("-", "") : text);
}

/** A label of a position as people read it: with a true minus sign. */
export const sign = (label) => label.replace("-", "−");

/** A set temperature, as it was set: "22.5", "−20". */
export const setTemperature = (temp_c) => (temp_c === null ? UNKNOWN : written(String(Number(temp_c.toFixed(3)) + 0)));

/** Units as people write them, in what the station says: "deg/s/g" → "°/s/g", "m/s2" → "m/s²". */
export const readable = (text) => text.replace(/\bdeg\/s\b/g, "°/s").replace(/\bm\/s2\b/g, "m/s²");

/** A number with so many significant digits, never in powers of ten. */
export function significant(value, digits) {
  if (!value) return number(value, 0);
  return number(value, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value)))));
}

/** "35 h 10 min", "4 min 20 s", "12 s". */
export function duration(seconds) {
  if (seconds === null || seconds === undefined) return UNKNOWN;
  const whole = Math.round(seconds);
  const two = (n) => String(n).padStart(2, "0");
  if (whole >= 3600) return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
  if (whole >= 60) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  return `${whole} s`;
}

/** "12 min", "3 h 20 min", "40 s": what is good enough for a look from afar. */
export function shortDuration(seconds) {
  if (seconds < 60) return `${Math.round(seconds)} s`;
  const minutes = Math.round(seconds / 60);
  if (minutes < 60) return `${minutes} min`;
  return minutes % 60 ? `${Math.floor(minutes / 60)} h ${minutes % 60} min` : `${minutes / 60} h`;
}

/** A time of day as the language writes it; `parts` as for Intl.DateTimeFormat. */
export const timeText = (date, parts = {}) => date.toLocaleTimeString(LOCALES[language], parts);

/** A date as the language writes it. */
export const dateText = (date, parts) => date.toLocaleDateString(LOCALES[language], parts);

/** "14:05", "tomorrow 04:12", "Thu 26 Nov, 04:12", in another year "Thu 26 Nov 2026, 04:12" (local time) of a time in seconds since 1970. */
export function timeOfDay(utc_s, now_s) {
  const [date, today] = [new Date(utc_s * 1000), new Date(now_s * 1000)];
  const time = timeText(date, { hour: "2-digit", minute: "2-digit" });
  const days = Math.round((new Date(date).setHours(0, 0, 0, 0) - today.setHours(0, 0, 0, 0)) / 86400000);
  if (days === 0) return time;
  if (days === 1) return `${new Intl.RelativeTimeFormat(LOCALES[language], { numeric: "auto" }).format(1, "day")} ${time}`;
  const year = date.getFullYear() === today.getFullYear() ? undefined : "numeric";
  return `${dateText(date, { weekday: "short", day: "numeric", month: "short", year })}, ${time}`;
}

/** A count with thin spaces between thousands. */
export function count(value) {
  return String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** A day in digits: "2026-11-26", in other languages as they write it. */
export const dayText = (date) => (language === "en" ? date.toLocaleDateString("en-CA") : dateText(date, { day: "2-digit", month: "2-digit", year: "numeric" }));

/** Local time of day, with the date unless it is today. */
export function clock(utc_s) {
  const date = new Date(utc_s * 1000);
  const time = timeText(date);
  if (date.toDateString() === new Date().toDateString()) return time;
  return `${dayText(date)} ${time}`;
}
