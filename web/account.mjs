// SPDX-License-Identifier: Apache-2.0
// Who is logged in, at a station that asks for it.

import { get, post } from "./api.mjs";
import { $, show } from "./dom.mjs";

/** The account's name takes the place of the one that people enter: the station writes no other into its log. */
export async function showAccount() {
  const { accounts, name, role } = await get("session");
  if (!accounts) return;
  $("user").value = name;
  $("user").readOnly = true;
  $("user").title = role;
  show($("log-out"), true);
  $("log-out").addEventListener("click", async () => {
    await post("logout", {});
    location.assign("login.html");
  });
}
