import { useState } from "preact/hooks";
import { login } from "../app";
import { RestError } from "../core/rest";
import * as words from "../words/frame";
import { Dialog } from "./dialog";
import { prose } from "./prose";

/**
 * Asks for the token; the server answers with a cookie that scripts cannot read. `again`: before the view, which keeps
 * what the user typed there.
 */
export function Login({ again }: { again: boolean }) {
  const [token, setToken] = useState("");
  const [error, setError] = useState("");
  const [closed, setClosed] = useState(0);
  const send = async (event: Event) => {
    event.preventDefault();
    setError("");
    try {
      await login(token.trim());
    } catch (failure) {
      setError(failure instanceof RestError ? failure.message : String(failure));
    }
  };
  const form = (
    <form class="login" onSubmit={(event) => void send(event)}>
      <h1>{words.product}</h1>
      <p>{again ? words.loginAgain : words.loginText}</p>
      <label class="field">
        <span>{words.loginField}</span>
        <input
          type="password"
          autocomplete="current-password"
          required
          autofocus
          value={token}
          onInput={(event) => setToken(event.currentTarget.value)}
        />
      </label>
      <p role="alert" class="error">
        {prose(error)}
      </p>
      <button type="submit" class="primary">
        {words.loginButton}
      </button>
    </form>
  );
  if (!again) return <main class="login-page">{form}</main>;
  return (
    <Dialog key={closed} title={words.loginButton} bare onClose={() => setClosed(closed + 1)}>
      {form}
    </Dialog>
  );
}
