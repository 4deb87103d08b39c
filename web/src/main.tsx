import { render } from "preact";
import { loginNeeded, startApp } from "./app";
import { startKeyboard } from "./core/keyboard";
import { startRouter } from "./core/router";
import { applyTheme } from "./core/settings";
import { KeyboardHelp } from "./parts/keyboard_help";
import { Login } from "./parts/login";
import { Search } from "./parts/search";
import { Shell } from "./parts/shell";
import "./style/page.css";
import { views } from "./views/views";

function Page() {
  return (
    <>
      {loginNeeded.value !== "first" && <Shell views={views} />}
      {loginNeeded.value && <Login again={loginNeeded.value === "again"} />}
      <Search />
      <KeyboardHelp />
    </>
  );
}

applyTheme();
startRouter();
startKeyboard();
startApp();
render(<Page />, document.body);
