import { defineConfig } from "vite";

// One script and one style sheet under names that stay: the monitor sends an entity tag with each, and the committed
// files differ only in what changed.
export default defineConfig({
  esbuild: { jsx: "automatic", jsxImportSource: "preact", legalComments: "none" },
  build: {
    target: "es2022",
    modulePreload: false,
    assetsInlineLimit: 0,
    cssCodeSplit: false,
    reportCompressedSize: true,
    rollupOptions: {
      output: {
        entryFileNames: "assets/page.js",
        assetFileNames: "assets/page[extname]",
        inlineDynamicImports: true,
      },
    },
  },
  // For work on the page: `sinew monitor` runs beside `npm run dev`, which sends it what is not the page's.
  server: {
    proxy: {
      "/api": "http://127.0.0.1:8080",
      "/panels": "http://127.0.0.1:8080",
    },
  },
  test: { environment: "node", include: ["test/**/*.test.ts"] },
} as Parameters<typeof defineConfig>[0]);
