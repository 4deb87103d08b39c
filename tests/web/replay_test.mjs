// A recording that an island plays is steered from the page, by keys alone.
import assert from "node:assert/strict";

/** Seconds of a place such as `1:40.5` or `0:07`. */
const secondsOf = (place) => place.split(":").reduce((sum, part) => 60 * sum + Number(part), 0);

async function playPauseSeek({ page, open, island }) {
  await island.startTape();
  await open("recordings");
  const card = page.getByRole("region", { name: "Replay log-tape" });
  const state = (word) => card.locator("header .state", { hasText: word }).waitFor();
  const place = async () => secondsOf(await card.locator(".replay-place strong").innerText());
  const reaches = (least, most = 10_000) =>
    page.waitForFunction(
      (range) => {
        const parts = document.querySelector(".replay-place strong").textContent.split(":");
        const seconds = parts.reduce((sum, part) => 60 * sum + Number(part), 0);
        return seconds >= range.least && seconds <= range.most;
      },
      { least, most },
    );
  await state("playing");
  await card.getByRole("button", { name: "Pause" }).press("Enter");
  await state("paused");
  await card.getByRole("textbox", { name: "Seek to" }).fill("100s");
  await page.keyboard.press("Enter");
  await reaches(100);
  await page.waitForTimeout(1500); // what is paused stands
  assert.ok((await place()) < 101, `${await place()} s while paused`);
  await card.getByRole("button", { name: "+30 s" }).press("Enter");
  await reaches(130);
  await card.getByRole("button", { name: "Play" }).press("Enter");
  await state("playing");
  await reaches(132);
  await card.getByRole("combobox", { name: "Speed" }).selectOption("100");
  await card.locator("header .muted", { hasText: "× 100" }).waitFor();
  await state("ended");
  await card.getByRole("combobox", { name: "Speed" }).selectOption("1");
  await card.locator("header .muted", { hasText: /× 1$/ }).waitFor();
  await card.getByRole("button", { name: "Play again" }).press("Enter");
  await state("playing");
  await reaches(2, 60);
}

/** The end is not known before it was reached. A line that ended is not one to open again. */
async function behindTheEnd({ page, open, island }) {
  await island.startTape();
  await open("recordings");
  const card = page.getByRole("region", { name: "Replay log-tape" });
  await card.locator("header .state", { hasText: "playing" }).waitFor();
  await card.getByRole("textbox", { name: "Seek to" }).fill("900000s");
  await page.keyboard.press("Enter");
  await card.locator("header .state", { hasText: "ended" }).waitFor();
  await card.getByRole("link", { name: "log-tape" }).click();
  const panel = page.getByRole("complementary", { name: "log-tape" });
  await panel.locator("header .state", { hasText: "ended" }).waitFor();
  assert.equal(await panel.getByRole("button", { name: "Open now" }).count(), 0);
}

export const tests = () => [
  { name: "replay: play, pause, seek, speed, again", body: playPauseSeek },
  { name: "replay: a place behind the end ends it", body: behindTheEnd },
];
