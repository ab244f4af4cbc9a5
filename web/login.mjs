// SPDX-License-Identifier: Apache-2.0
// The page at which one logs in. Where the station had been looked at before stands behind # in the address.

import { post } from "./api.mjs";
import { $, english, show } from "./dom.mjs";
import { connectLanguage, T } from "./text.mjs";

connectLanguage($("language"));
document.title = T.login.page;
$("name").focus();

$("log-in").addEventListener("submit", async (event) => {
  event.preventDefault();
  show($("failure"), false);
  $("send").disabled = true;
  try {
    await post("login", { name: $("name").value.trim(), password: $("password").value });
    location.replace(`/${location.hash}`);
  } catch (error) {
    $("failure").replaceChildren(english(error.message));
    show($("failure"), true);
    $("password").value = "";
    $("password").focus();
  }
  $("send").disabled = false;
});
