// SPDX-License-Identifier: Apache-2.0
// The websocket to the scope's server: signs of life, and what is told and asked.

const BEAT_MS = 100;
const AGAIN_MS = 1000;
export const token = new URLSearchParams(location.search).get("token") ?? "";

export class Link {
  // `heard` has a function for each type of message; `away` is told when the server is gone.
  constructor(heard, away) {
    this.heard = heard;
    this.away = away;
    this.#open();
    // A page that hangs, or that nobody sees, gives no signs, and what it armed is switched off.
    setInterval(() => document.visibilityState === "visible" && this.say("beat"), BEAT_MS);
  }

  #open() {
    const address = `ws://${location.host}/live?token=${encodeURIComponent(token)}`;
    this.socket = new WebSocket(address);
    this.socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      this.heard[message.type]?.(message);
    };
    this.socket.onclose = () => {
      this.away();
      setTimeout(() => this.#open(), AGAIN_MS);
    };
  }

  say(type, more = {}) {
    if (this.socket.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify({ type, ...more }));
    }
  }
}
