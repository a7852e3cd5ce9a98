// Draws the plots of the page, in the colours of the scheme; the buttons of the page move the time axis.
"use strict"
const views = [] // of the layouts
const roots = [] // their models
const plots = () => document.querySelectorAll(".plot")
const within = (node) => [...node.querySelectorAll("*")].flatMap((element) => // plots are in shadows
  [element, ...(element.shadowRoot ? within(element.shadowRoot) : [])])
const time = () => roots.map((root) => root.document.get_model_by_name("time")).find((range) => range)

const dark = matchMedia("(prefers-color-scheme: dark)")
function recolour(isDark) {
  const [ink, grid, ground] = isDark ? ["#d6d6da", "#303238", "#16171a"] : ["#3c3c42", "#e4e4e8", "#ffffff"]
  for (const root of roots) {
    for (const model of root.references()) {
      if (model.type.endsWith("Axis")) {
        model.setv({ axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: ink, major_tick_line_color: ink })
      } else if (model.type === "Grid") model.setv({ grid_line_color: grid })
      else if (model.type === "Legend") model.setv({ label_text_color: ink, background_fill_color: ground })
      else if (model.type === "Label" || model.type === "Title") model.setv({ text_color: ink })
      else if (model.type === "ColorBar") model.setv({ major_label_text_color: ink, title_text_color: ink })
    }
  }
}
dark.addEventListener("change", () => recolour(dark.matches))
function repaint(view) {
  if (view.model.type === "Figure") view.repaint()
  for (const child of view.child_views ?? []) repaint(child)
}
const LINE = 690 // pixels on A4 with margins of 13 mm
function onPaper(plot) { // drawn for the screen, scaled to the paper
  const { offsetWidth, offsetHeight } = plot
  const scale = Math.min(1, LINE / offsetWidth)
  plot.style.height = `${scale * offsetHeight}px`
  const drawn = plot.firstElementChild.style
  drawn.width = `${offsetWidth}px`
  drawn.transform = `scale(${scale})`
}
function toolbars(visibility) {
  for (const { classList, style } of within(document)) if (classList.contains("bk-Toolbar")) style.visibility = visibility
}
addEventListener("beforeprint", () => { // paper does not wait for the next frame
  recolour(false)
  views.forEach(repaint)
  toolbars("hidden")
  plots().forEach(onPaper)
})
addEventListener("afterprint", () => {
  recolour(dark.matches)
  toolbars("")
  for (const plot of plots()) plot.style.height = plot.firstElementChild.style.width = plot.firstElementChild.style.transform = ""
})

function handsOn() { // a finger that goes up or down moves the page, not the plot
  for (const element of within(document)) {
    if (element.classList.contains("bk-events")) element.style.setProperty("touch-action", "pan-y", "important")
  }
  for (const root of roots) {
    for (const model of root.references()) {
      if (model.type !== "Figure") continue
      const pan = model.toolbar.tools.find((tool) => tool.type === "PanTool")
      if (pan) model.toolbar.active_drag = pan
    }
  }
}

function show(from, to) {
  const range = time()
  const [first, last] = range.bounds
  range.setv({ start: Math.max(first, from), end: Math.min(last, to) })
}
addEventListener("click", ({ target }) => {
  const { from, to } = target.dataset
  if (from === undefined) return
  show(Number(from), Number(to))
  document.getElementById("over-time").scrollIntoView({ behavior: "smooth" })
})

async function draw() {
  for (const holder of document.querySelectorAll("script[type='application/json'][data-plot]")) {
    const item = JSON.parse(holder.textContent)
    const manager = await Bokeh.embed.embed_item(item)
    views.push(...manager.roots)
    roots.push(...manager.roots.map((view) => view.model))
  }
  recolour(dark.matches)
  if (matchMedia("(pointer: coarse)").matches) handsOn()
  document.documentElement.dataset.drawn = String(roots.length)
}
draw()
