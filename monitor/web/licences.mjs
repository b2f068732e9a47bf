// usage: licences.mjs FOLDER
// Writes FOLDER/licences.txt: the licence of each package whose code is in the built page.
import { readFileSync, writeFileSync, readdirSync } from "node:fs";

const { dependencies } = JSON.parse(readFileSync("package.json", "utf8"));
const names = new Set(Object.keys(dependencies));
for (const name of [...names])
  for (const needed of Object.keys(JSON.parse(readFileSync(`node_modules/${name}/package.json`, "utf8")).dependencies ?? {}))
    names.add(needed);

let text = "The page of sinew monitor contains code of these packages.\n";
for (const name of [...names].sort()) {
  const folder = `node_modules/${name}`;
  const { version, license, homepage } = JSON.parse(readFileSync(`${folder}/package.json`, "utf8"));
  const file = readdirSync(folder).find((f) => /^licen[cs]e/i.test(f));
  if (!file) throw new Error(`${name} has no licence file`);
  text += `\n${"=".repeat(80)}\n${name} ${version} (${license})${homepage ? `, ${homepage}` : ""}\n\n`;
  text += `${readFileSync(`${folder}/${file}`, "utf8").trim()}\n`;
}
writeFileSync(`${process.argv[2]}/licences.txt`, text);
