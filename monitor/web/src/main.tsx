import { render } from "preact";
import "uplot/dist/uPlot.min.css";
import "./style.css";
import { App } from "./app";
import * as monitor from "./monitor";
import * as page from "./page";

monitor.begin(); // first: it takes the token out of the address
page.begin();
render(<App />, document.getElementById("page")!);
