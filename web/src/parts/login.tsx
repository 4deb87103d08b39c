import { useState } from "preact/hooks";
import { login } from "../app";
import { RestError } from "../core/rest";
import * as words from "../words/frame";

/** Asks for the token; the server answers with a cookie that scripts cannot read. */
export function Login() {
  const [token, setToken] = useState("");
  const [error, setError] = useState("");
  const send = async (event: Event) => {
    event.preventDefault();
    setError("");
    try {
      await login(token.trim());
    } catch (failure) {
      setError(failure instanceof RestError ? failure.message : String(failure));
    }
  };
  return (
    <main class="login">
      <form onSubmit={(event) => void send(event)}>
        <h1>{words.product}</h1>
        <p>{words.loginText}</p>
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
          {error}
        </p>
        <button type="submit" class="primary">
          {words.loginButton}
        </button>
      </form>
    </main>
  );
}
