// Search in pages that were opened from a disk: browsers start no workers there, so a hidden frame
// does what the worker would.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      this.frame = document.body.appendChild(document.createElement("iframe"))
      this.frame.hidden = true
      const inside = this.frame.contentDocument
      inside.open()
      inside.write(`<!doctype html><script>
        window.postMessage = (data) => parent.postMessage(data, "*")
        window.importScripts = (...urls) => urls.reduce((before, url) => before.then(() =>
          new Promise((loaded, failed) => {
            const script = document.createElement("script")
            script.src = new URL(url, ${JSON.stringify(String(url))})
            script.onload = loaded
            script.onerror = failed
            document.body.appendChild(script)
          })), Promise.resolve())
      <\/script><body><script src=${JSON.stringify(String(url))}><\/script>`)
      inside.close()
      window.addEventListener("message", (event) => {
        if (event.source !== this.frame.contentWindow) return
        this.dispatchEvent(new MessageEvent("message", { data: event.data }))
        if (this.onmessage) this.onmessage(event)
      })
    }
    postMessage(data) {
      const tell = () => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }))
      if (this.frame.contentDocument.readyState === "complete") tell()
      else this.frame.contentWindow.addEventListener("load", tell)
    }
    terminate() { this.frame.remove() }
  }
}
