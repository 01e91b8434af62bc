// Search from the file system: a browser starts no worker from a file, so its script runs in a hidden frame instead.
if (location.protocol === "file:") {
  window.IFrameWorker = window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const load = (source) => new Promise((done) => {
        const script = frame.contentDocument.createElement("script");
        script.src = source;
        script.onload = done;
        frame.contentDocument.body.append(script);
      });
      frame.contentWindow.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", {data}));
      frame.contentWindow.importScripts = (...sources) => sources.reduce((before, source) => before.then(() => load(source)), Promise.resolve());
      this.frame = frame;
      this.ready = load(url);
    }
    postMessage(data) {
      this.ready.then(() => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", {data})));
    }
    terminate() {
      this.frame.remove();
    }
  };
}
