// SPDX-License-Identifier: Apache-2.0
// Who is logged in, at a station that asks for it, and what of the page is not for that role (docs/access.md).

import { get, post } from "./api.mjs";
import { $, say, show } from "./dom.mjs";
import { T } from "./text.mjs";

/** Whether whoever is here may answer the station; known once it has said who that is. */
export const mayOperate = () => document.body.dataset.role !== "viewer";

/** The role of whoever is here; null at a station without accounts. */
export const roleHere = () => document.body.dataset.role ?? null;

/**
 * The account's name takes the place of the one that people enter, wherever a name goes into a record: the station writes no other. What the role may not do
 * the style sheet takes away by `data-needs`, whatever else shows or enables it.
 */
export async function showAccount() {
  const { accounts, name, role } = await get("session");
  if (!accounts) return;
  document.body.dataset.role = role;
  for (const field of document.querySelectorAll("input[data-signs]")) Object.assign(field, { defaultValue: name, value: name, readOnly: true });
  say($("role"), T.roleNames[role] ?? role);
  $("role").title = T.roles[role] ?? "";
  $("user").title = `${T.roleNames[role] ?? role}: ${T.roles[role] ?? ""}`;
  show($("role"), true);
  show($("log-out"), true);
  $("log-out").addEventListener("click", async () => {
    await post("logout", {});
    location.assign("login.html");
  });
}
