// The worker that decodes, so that the page goes on drawing.

import { ShadowFileError } from '../error.js';
import { run } from '../file/steps.js';
import { Decoding } from './decode.js';
import type { DecodeAnswer, DecodeRequest } from './decoder.js';

const decoding = new Decoding();

addEventListener('message', ({ data: { id, job } }: MessageEvent<DecodeRequest>) => {
  const answer = answerTo(id, job);
  postMessage(answer, { transfer: answer.words === undefined ? [] : [answer.words.buffer] });
});

function answerTo(id: number, job: DecodeRequest['job']): DecodeAnswer {
  try {
    return { id, words: run(decoding.do(job)) };
  } catch (error) {
    if (!(error instanceof ShadowFileError)) throw error;
    const { kind, message, details, fault } = error;
    return { id, error: { kind, message, details, fault } };
  }
}
