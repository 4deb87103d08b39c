// What the bundler puts in the place of JSX.
export { Fragment, h } from "preact";
