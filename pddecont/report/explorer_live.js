// A page on a run that goes on: it is read anew while nobody uses it just then.

// Milliseconds: how long after the last key or click the page is not taken away, how often it is looked whether it may
// be, and after how long without anything new the run may have ended.
const LEFT_ALONE = 2000,
  LOOKED = 500,
  OLD = 60_000;
// The page of a run that may have ended is read anew so much less often.
const LESS_OFTEN = 6;

function followRun(explorer) {
  const said = document.getElementById("explorer-live");
  if (!said.dataset.written) return;
  const [written, every] = [Number(said.dataset.written), Number(said.dataset.every)];
  const opened = Date.now();
  let used = opened,
    isDown = false;
  for (const name of ["pointerdown", "pointerup", "keydown", "wheel"])
    window.addEventListener(
      name,
      () => {
        used = Date.now();
        if (name.startsWith("pointer")) isDown = name === "pointerdown";
      },
      true,
    );
  const look = () => {
    const [now, at] = [Date.now(), new Date(written).toLocaleTimeString()];
    const isOld = now - written > OLD;
    said.textContent = isOld
      ? `The run had not ended at ${at}; there is nothing new since then. It may have been stopped.`
      : `The run goes on; this is what it had found at ${at}.`;
    const isUsed = isDown || now - used < LEFT_ALONE || !window.getSelection().isCollapsed;
    if (isUsed || document.hidden || now - opened < every * (isOld ? LESS_OFTEN : 1)) return;
    saveState(explorer);
    location.reload();
  };
  look();
  setInterval(look, LOOKED);
}
