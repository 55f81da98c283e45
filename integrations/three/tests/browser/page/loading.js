// Loads a file, and measures the longest time for which the page did nothing else.

import { ShadowFileLoader } from 'adumbra-three';

window.load = async (url) => {
  const ticks = new MessageChannel();
  let [longest, last, isOver] = [0, performance.now(), false];
  ticks.port1.onmessage = () => {
    const now = performance.now();
    longest = Math.max(longest, now - last);
    last = now;
    if (!isOver) ticks.port2.postMessage(null);
  };
  ticks.port2.postMessage(null);
  const start = performance.now();
  const file = await new ShadowFileLoader().loadAsync(url);
  const milliseconds = performance.now() - start;
  isOver = true;
  return { longest, milliseconds, levelCount: file.levelCount };
};
window.isReady = true;
