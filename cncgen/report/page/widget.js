// The page as a widget of a notebook (anywidget): a frame, whose view, moment and line are values of the model.

function render({ model, el }) {
  const frame = document.createElement("iframe"), heard = {};
  frame.title = "cncgen";
  frame.setAttribute("sandbox", "allow-scripts");
  frame.style.cssText = `width:100%;height:${model.get("height")}px;border:1px solid #8884;border-radius:8px`;
  frame.srcdoc = model.get("page");
  const ask = (name) => frame.contentWindow?.postMessage({ cncgen: { [name]: model.get(name) } }, "*");
  let met = false;
  const listen = ({ source, data }) => {
    if (source !== frame.contentWindow || !data?.cncgen) return;
    if (!met) {
      // A frame begins with the view and the moment that the model has.
      met = true;
      const view = model.get("view"), moment = model.get("t_s");
      if (view) ask("view");
      if (moment && moment !== Number(new URLSearchParams(view).get("t"))) ask("t_s");
      if (view || moment) return;
    }
    for (const name of ["view", "t_s", "line"]) if (name in data.cncgen) model.set(name, (heard[name] = data.cncgen[name]));
    model.save_changes();
  };
  const asked = ["view", "t_s"].map((name) => [`change:${name}`, () => model.get(name) !== heard[name] && ask(name)]);
  for (const [event, action] of asked) model.on(event, action);
  addEventListener("message", listen);
  el.append(frame);
  return () => {
    removeEventListener("message", listen);
    for (const [event, action] of asked) model.off(event, action);
  };
}

export default { render };
