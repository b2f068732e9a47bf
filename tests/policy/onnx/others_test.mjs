// Every network of the zoo in another runtime: onnxruntime-web, WebAssembly under node. usage: others_test.mjs ZOO
// ZOO holds what policy_onnx_zoo wrote. Prints the largest difference of each network; exit 1 when one is above the limit.
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { createRequire } from "node:module";

const require = createRequire(new URL("./others/", import.meta.url));
const ort = require("onnxruntime-web");
ort.env.wasm.numThreads = 1;

const LIMIT = 1e-5; // of the value, and at least of 1
const folder = process.argv[2];
const names = readdirSync(folder).filter((name) => name.endsWith(".onnx")).map((name) => name.slice(0, -5)).sort();
let failed = 0;
let numbers = 0;
let worst = 0;
for (const name of names) {
  const ours = JSON.parse(readFileSync(join(folder, `${name}.json`), "utf8"));
  let most = 0;
  let why = "";
  try {
    const session = await ort.InferenceSession.create(readFileSync(join(folder, `${name}.onnx`)), { executionProviders: ["wasm"] });
    const feeds = {};
    for (const [port, { dims, data }] of Object.entries(ours.inputs)) feeds[port] = new ort.Tensor("float32", Float32Array.from(data), dims);
    const theirs = await session.run(feeds);
    for (const [port, { dims, data }] of Object.entries(ours.outputs)) {
      const other = theirs[port];
      if (JSON.stringify([...other.dims].map(Number)) !== JSON.stringify(dims)) why = `${port}: shape ${other.dims} there, ${dims} here`;
      for (let i = 0; i < data.length; ++i) {
        const off = Math.abs(other.data[i] - data[i]) / Math.max(1, Math.abs(other.data[i]));
        if (!(off <= most)) most = off;
        ++numbers;
      }
    }
  } catch (error) {
    why = String(error);
  }
  if (!(most <= LIMIT)) why ||= `differs by ${most}`;
  worst = Math.max(worst, most);
  if (why) ++failed;
  console.log(`${why ? "FAILED" : "ok"} ${name} ${most.toExponential(1)}${why ? `: ${why}` : ""}`);
}
if (names.length === 0) console.log(`no networks in ${folder}`);
console.log(`${failed ? `FAILED ${failed} of` : "OK"} ${names.length} networks, ${numbers} numbers, at most ${worst.toExponential(1)} from onnxruntime-web ${ort.env.versions.web}`);
process.exit(failed || names.length === 0 ? 1 : 0);
