// A panel of one's own: sinew monitor --panels examples/panels, then "Height" in the list of panels. One file, no build.

const kTopic = "/filter.state"; // of the quadrotor; another robot says that it has none
const kSeconds = 20;

export function mount(element, robot) {
  const text = element.appendChild(document.createElement("p"));
  const canvas = element.appendChild(document.createElement("canvas"));
  const button = element.appendChild(document.createElement("button"));
  text.textContent = `waiting for ${kTopic} of ${robot.name}`;
  text.style.fontSize = "28px";
  canvas.style.width = "100%";
  button.className = "button plain"; // the page's own look
  button.textContent = "Disarm";
  button.onclick = () => robot.command("disarm"); // what is refused stands above the panels

  const heights = []; // [time in s, height in m]
  const end = robot.subscribe(kTopic, (message, time_ns) => {
    const time = time_ns / 1e9;
    heights.push([time, message.height_m]);
    while (heights.length && time - heights[0][0] > kSeconds) heights.shift();
  });

  const colour = (name) => getComputedStyle(element).getPropertyValue(name); // follows light and dark
  const timer = setInterval(() => {
    if (heights.length === 0) return;
    const [now, height] = heights.at(-1);
    text.textContent = `${height.toFixed(2)} m`;
    const width = (canvas.width = canvas.clientWidth), tall = (canvas.height = 120);
    const most = Math.max(0.1, ...heights.map(([, h]) => h));
    const draw = canvas.getContext("2d");
    draw.strokeStyle = colour("--accent");
    draw.lineWidth = 2;
    draw.beginPath();
    for (const [time, h] of heights) draw.lineTo(width * (1 - (now - time) / kSeconds), tall - 4 - (h / most) * (tall - 8));
    draw.stroke();
  }, 50);

  return () => {
    clearInterval(timer);
    end();
  };
}
