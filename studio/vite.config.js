import { defineConfig } from "vite";

// The built page is part of the Python package, so that users need no Node.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/habilis/studio/page",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      output: {
        entryFileNames: "assets/studio.js",
        chunkFileNames: "assets/[name].js",
        assetFileNames: "assets/studio[extname]",
      },
    },
  },
  // `npm run dev` beside a running `habilis studio --port 8765`
  server: {
    proxy: {
      "/ws": {
        target: "http://127.0.0.1:8765",
        ws: true,
        changeOrigin: true,
        rewriteWsOrigin: true, // the studio answers no page but its own
      },
    },
  },
});
