// Sends what the controls say, and draws what comes back; the last request wins.
"use strict"
const settings = JSON.parse(document.getElementById("settings").textContent)
const form = document.getElementById("controls")
const by = (id) => document.getElementById(id)
const PATIENCE = 250 // ms without an answer after which the page says that it is computing
const FIRST = "computing: functions are compiled the first time, which takes some minutes"
const RETRY = [250, 500, 1000, 2000, 4000] // ms between attempts to connect

// ---- plots ----
const views = {} // of the plots, by name
const roots = []
const model = (name) => { for (const root of roots) { const found = root.document.get_model_by_name(name); if (found) return found } }
const dark = matchMedia("(prefers-color-scheme: dark)")

function recolour() {
  const [ink, grid] = dark.matches ? ["#d6d6da", "#303238"] : ["#3c3c42", "#e4e4e8"]
  for (const root of roots) {
    for (const part of root.references()) {
      if (part.type.endsWith("Axis")) {
        part.setv({ axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: ink, major_tick_line_color: ink })
      } else if (part.type === "Grid") part.setv({ grid_line_color: grid })
      else if (part.type === "Label") part.setv({ text_color: ink })
      else if (part.type === "ColorBar") part.setv({ major_label_text_color: ink, title_text_color: ink })
    }
  }
}
dark.addEventListener("change", recolour)

function spans(tag, change) {
  for (const name of ["forces", "stresses"]) {
    for (const part of views[name].model.center) if (part.type === "Span" && part.tags[0] === tag) change(part)
  }
}

const places = () => [views.forces.model.x_range, views.stresses.model.x_range]
function together() { // both plots show the same part of the track
  const [first, second] = places()
  for (const [one, other] of [[first, second], [second, first]]) {
    one.change.connect(() => { if (other.start !== one.start || other.end !== one.end) other.setv({ start: one.start, end: one.end }) })
  }
}

// ---- messages ----
function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true)
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)))
  let at = 4 + length
  for (const [name, size] of Object.entries(header.arrays)) {
    header.arrays[name] = new Float32Array(buffer, at, size)
    at += 4 * size
  }
  return header
}

let socket = null
let attempt = 0
let asked = 0 // number of the latest request
let answered = 0 // number of the answer that is shown
let askedAt = 0
let late = 0 // timer
let lastAnswer = NaN // ms from the latest change to its curves
let shownQuery = location.search.slice(1) // of the answer to the latest request
let shown = null // the answer
let patienceWords = ""

function connect() {
  const address = new URL("socket", location.href)
  address.protocol = "ws:"
  socket = new WebSocket(address)
  socket.binaryType = "arraybuffer"
  socket.onopen = () => {
    attempt = 0
    ask()
    listPins()
    askPins()
    const names = map?.names ?? settings.map.split(":")
    if (names.length === 3 && names[0] !== names[1]) fill(names)
  }
  socket.onmessage = ({ data }) => receive(unpacked(data))
  socket.onclose = () => {
    clearTimeout(late)
    say(attempt < 2 ? "reconnecting" : "the program has ended: start it again, and open the address that it prints", attempt >= 2)
    setTimeout(connect, RETRY[Math.min(attempt++, RETRY.length - 1)])
  }
}
function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message))
}

function say(words, refused = false) {
  const status = by("status")
  if (status.textContent !== words) status.textContent = words
  status.classList.toggle("refused", refused)
  document.body.classList.toggle("computing", words.startsWith("computing"))
}

function receive(message) {
  const { kind, number } = message
  if (kind === "moment") return drawMoment(message)
  if (kind === "scatter" || kind === "fatigue") {
    if (number !== asked) return
    by(kind).textContent = message.words
    if (message.source) by("fatigue-source").textContent = message.source
    document.documentElement.dataset[kind] = `${number}:${message.done ?? ""}`
    return
  }
  if (kind === "map") return drawCell(message)
  if (kind === "measured") return drawMeasured(message)
  if (kind === "pin") return drawPin(message)
  if (kind === "progress") { if (number === asked) { patienceWords = message.words; say(`computing: ${message.words}`) } return }
  if (kind === "refused") {
    if (number < asked) return
    clearTimeout(late)
    for (const id of ["measured-words", "map-words"]) if (by(id).textContent === "computing") by(id).textContent = ""
    return say(message.words, true)
  }
  if (kind === "answer" && number > answered) drawAnswer(message)
}

// ---- controls ----
function controls() {
  const values = {}
  for (const control of form.querySelectorAll("[name]")) values[control.name] = control.value
  return values
}
function fit() { // shows the controls that apply
  const { kind, rough } = controls()
  for (const control of form.querySelectorAll("[data-kinds]")) control.hidden = !control.dataset.kinds.split(" ").includes(kind)
  form.querySelector("[data-control=level]").hidden = rough !== "1"
  form.querySelector("[data-control=on]").hidden = kind === "none"
  offerSides()
}
function ask() {
  asked += 1
  askedAt = performance.now()
  patienceWords = ""
  send({ number: asked, view: controls() })
  clearTimeout(late)
  late = setTimeout(() => {
    if (!patienceWords) say("computing")
    late = setTimeout(() => { if (!patienceWords) say(FIRST) }, 20 * PATIENCE)
  }, PATIENCE)
}
form.addEventListener("input", ({ target }) => {
  const name = target.id.replace(/-slider$/, "")
  if (target.type === "range") by(name).value = target.value
  else if (by(`${name}-slider`)) by(`${name}-slider`).value = target.value
  fit()
  ask()
})
form.addEventListener("submit", (event) => event.preventDefault())

// ---- pins and files ----
let pins = settings.pins.map((query) => ({ query })) // with title and words when answered
function link() { return `?${shownQuery}${map ? `&map=${map.names.join(":")}` : ""}${pins.map(({ query }) => `&pin=${encodeURIComponent(query)}`).join("")}` }
function pinCurves(pin, place, force, stress) {
  for (const [kind, value] of [["force", force], ["stress", stress]]) model(`${kind}-pin${pin}`).data = { place, value }
}
function askPins() { // with the stress that the page shows
  settings.pinColours.forEach((_, pin) => {
    if (pin >= pins.length) return pinCurves(pin, new Float32Array(0), new Float32Array(0), new Float32Array(0))
    const view = { ...Object.fromEntries(new URLSearchParams(pins[pin].query)), stress: by("stress").value }
    send({ number: asked, pin, view })
  })
}
function listPins() {
  by("pins").replaceChildren(...pins.map(({ title, words }, pin) => {
    const item = document.createElement("li"), text = document.createElement("div")
    const mark = document.createElement("i")
    mark.style.setProperty("--colour", settings.pinColours[pin])
    for (const [line, quiet] of [[title ?? "computing", ""], [words ?? "", "quiet"]]) {
      const span = document.createElement("span")
      span.textContent = line
      span.className = quiet
      text.append(span)
    }
    item.append(mark, text, pinButton("show", title, () => set(pins[pin].query)), pinButton("remove", title, () => {
      pins.splice(pin, 1)
      changed()
      by("pin").focus()
    }))
    return item
  }))
  by("pin").disabled = pins.length >= settings.pinColours.length
}
function pinButton(name, title, act) {
  const button = document.createElement("button")
  button.type = "button"
  button.textContent = name
  button.setAttribute("aria-label", `${name} ${title ?? "pinned curve"}`)
  button.addEventListener("click", act)
  return button
}
function changed() {
  listPins()
  askPins()
  history.replaceState(null, "", link())
}
function set(query) { // the controls to what a link says
  for (const [name, value] of new URLSearchParams(query)) {
    if (name === "stress") continue
    by(name).value = value
    if (by(`${name}-slider`)) by(`${name}-slider`).value = value
  }
  fit()
  ask()
}
function drawPin({ pin, query, title, words, arrays }) {
  if (!pins[pin] || new URLSearchParams(pins[pin].query).get("kind") !== new URLSearchParams(query).get("kind")) return
  Object.assign(pins[pin], { title, words })
  pinCurves(pin, arrays.place, arrays.force, arrays.stress)
  listPins()
  document.documentElement.dataset.pinned = String(pins.filter((each) => each.title).length)
}
by("pin").addEventListener("click", () => {
  if (!shown || pins.length >= settings.pinColours.length) return
  pins.push({ query: shownQuery })
  changed()
})
by("stress").addEventListener("input", askPins)
for (const button of document.querySelectorAll("[data-suffix]")) {
  button.addEventListener("click", async () => {
    const { suffix } = button.dataset
    say(`computing: ${button.textContent}`)
    try {
      const response = await fetch(`download?suffix=${suffix}&${shownQuery}`)
      if (!response.ok) return say(await response.text(), true)
      const file = document.createElement("a")
      file.href = URL.createObjectURL(await response.blob())
      file.download = `${document.querySelector("h1").textContent.replace(/[^\w-]+/g, "_")}_explored${suffix}`
      file.click()
      setTimeout(() => URL.revokeObjectURL(file.href), 60000)
      say("")
    } catch { say("the file did not come: is the program still there?", true) }
  })
}

// ---- maps ----
let map = null // names of both sliders and the quantity, their values, cells
const slidersShown = () => [...form.querySelectorAll("input[type=number]")].filter((input) => !input.closest(".control").hidden)
function offerSides() {
  const names = slidersShown().map((input) => input.name)
  for (const [id, preferred] of [["map-x", "speed"], ["map-y", names[0]]]) {
    const select = by(id), before = select.value
    if ([...select.options].map((option) => option.value).join() === names.join()) continue
    select.replaceChildren(...names.map((name) => new Option(form.querySelector(`label[for=${name}]`).textContent, name)))
    select.value = names.includes(before) ? before : preferred
  }
}
function fill(names) {
  const [x, y] = names
  const sides = [x, y].map((name) => by(name))
  if (sides.some((side) => !side)) return
  map = { names, serial: (map?.serial ?? 0) + 1, sides, cells: null, count: 0 }
  by("map").hidden = false
  for (const [id, name] of [["map-x", x], ["map-y", y], ["map-quantity", names[2]]]) by(id).value = name
  send({ number: map.serial, map: names, view: controls() })
  history.replaceState(null, "", link())
  by("map-words").textContent = "computing"
}
by("map-fill").addEventListener("click", () => fill([by("map-x").value, by("map-y").value, by("map-quantity").value]))
function drawCell({ number, cell: [row, column], value, done, of }) {
  if (!map || number !== map.serial) return
  const count = Math.round(Math.sqrt(of))
  const [x, y] = map.sides.map((side) => {
    const low = Number(side.min), high = Number(side.max), step = (high - low) / (count - 1)
    return { low: low - step / 2, high: high + step / 2, step, name: form.querySelector(`label[for=${side.name}]`).textContent, unit: side.parentElement.querySelector(".unit").textContent }
  })
  map.cells ??= new Float32Array(of).fill(NaN)
  map.count = count
  map.axes = [x, y]
  map.cells[row * count + column] = value ?? NaN
  if (done % count && done < of) return
  const known = map.cells.filter((each) => !Number.isNaN(each))
  const low = Math.min(...known), high = Math.max(...known)
  model("map-colours").setv({ low, high: Math.max(high, low + 1e-6) })
  model("map-x").setv({ start: x.low, end: x.high })
  model("map-y").setv({ start: y.low, end: y.high })
  const figure = views.map.model
  figure.below[0].axis_label = `${x.name} (${x.unit || "1"})`
  figure.left[0].axis_label = `${y.name} (${y.unit || "1"})`
  model("map-cells").data = { image: [ndarray(map.cells.slice(), [count, count])], x: [x.low], y: [y.low], dw: [x.high - x.low], dh: [y.high - y.low] }
  here()
  const quantity = by("map-quantity").querySelector(`[value=${map.names[2]}]`).textContent
  by("map-words").textContent = `${quantity} of the view when you filled it: ${low.toFixed(0)} to ${high.toFixed(0)}${done < of ? `, ${of - done} cells to come` : ". Click a cell to go there."}`
  document.documentElement.dataset.map = `${number}:${done}`
}
function here() { // where the sliders are
  if (map?.cells) model("map-here").data = { x: [Number(map.sides[0].value)], y: [Number(map.sides[1].value)] }
}
by("map").addEventListener("click", (event) => {
  const view = views.map
  if (!map?.cells) return
  const box = view.el.getBoundingClientRect()
  const at = [view.frame.x_scale.invert(event.clientX - box.left), view.frame.y_scale.invert(event.clientY - box.top)]
  at.forEach((value, side) => {
    const { low, step } = map.axes[side], input = map.sides[side]
    const cell = Math.min(Math.max(Math.floor((value - low) / step), 0), map.count - 1)
    const size = Number(by(`${input.name}-slider`).step)
    input.value = String(Number((Math.round((Number(input.min) + cell * step) / size) * size).toFixed(6)))
    by(`${input.name}-slider`).value = input.value
  })
  fit()
  ask()
})

// ---- measurements ----
async function take(file) {
  if (!file) {
    model("force-measured").data = { place: new Float32Array(0), value: new Float32Array(0) }
    by("measured-words").textContent = ""
    return send({ number: asked, name: "", measured: "" })
  }
  if (file.size > 15e6) return say(`${file.name} has ${(file.size / 1e6).toFixed(0)} MB: give up to 15 MB around the impact`, true)
  by("measured-words").textContent = "computing"
  send({ number: asked, name: file.name, measured: await file.text() })
}
by("measured").addEventListener("change", ({ target }) => take(target.files[0]))
addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("dropping") })
addEventListener("dragleave", () => document.body.classList.remove("dropping"))
addEventListener("drop", (event) => {
  event.preventDefault()
  document.body.classList.remove("dropping")
  take(event.dataTransfer.files[0])
})
function drawMeasured({ number, words, arrays }) {
  by("measured-words").textContent = words
  model("force-measured").data = { place: arrays.place, value: arrays.force }
  document.documentElement.dataset.measured = String(number)
}

// ---- answers ----
function drawAnswer({ number, query, nodes, bay, row, readouts, marks, verdicts, sources, seconds, arrays }) {
  answered = number
  if (number === asked) {
    clearTimeout(late)
    shownQuery = query
    history.replaceState(null, "", link())
    say("")
  }
  const { place } = arrays
  shown = { number, place, row, nodes, arrays }
  const force = { place, value0: arrays.force0, value1: arrays.force1 }
  const stress = { place }
  const nothing = new Float32Array(place.length).fill(NaN)
  for (let node = 0; node < settings.colours.length; node++) stress[`value${node}`] = arrays[`stress${node}`] ?? nothing
  model("force-curves").data = force
  model("stress-curves").data = stress
  ranges(force, stress)
  spans("sleeper", (span) => { span.location = span.tags[1] * bay })
  for (const part of views.forces.model.center) {
    if (part.tags[0] !== "limit") continue
    const [force, label] = marks[part.tags[1]] ?? [null, ""]
    part.setv(part.type === "Span" ? { location: force } : { y: force ?? 0, text: label, visible: force !== null })
  }
  by("verdicts").replaceChildren(...verdicts.map(({ words, level }) => {
    const item = document.createElement("li")
    item.textContent = words
    item.className = level
    return item
  }))
  by("scatter").textContent = by("fatigue").textContent = by("fatigue-source").textContent = ""
  by("sources").textContent = sources.length ? `Limits: ${sources.join("; ")}.` : ""
  for (const [name, text] of Object.entries(readouts)) by(name).textContent = text
  by("nodes").innerHTML = nodes.map((name, node) => `<i style="--colour:${settings.colours[node]}"></i>${name}`).join(" ")
  by("stress-words").textContent = by("stress").value === "turning"
    ? "of the point around the axle that has the largest range, as it turns" : "at the top of the axle, which does not turn"
  lastAnswer = performance.now() - askedAt
  by("seconds").textContent = `${Math.round(1000 * seconds)} ms of work, ${Math.round(lastAnswer)} ms from change to curve`
  by("moment").max = place.length - 1
  here()
  mark(row)
  document.documentElement.dataset.answered = String(number)
}
function ranges(force, stress) {
  let top = 370, low = Infinity, high = -Infinity
  for (const values of [force.value0, force.value1]) for (const value of values) if (value > top) top = value
  for (const name of Object.keys(stress)) {
    if (name === "place") continue
    for (const value of stress[name]) { if (value < low) low = value; if (value > high) high = value }
  }
  const margin = 0.08 * (high - low)
  model("force-range").setv({ start: 0, end: 1.08 * top })
  model("stress-range").setv({ start: low - margin, end: high + margin })
  const { place } = force, ends = [place[0], place[place.length - 1]]
  for (const range of places()) {
    if (range.tags.join() !== ends.join()) range.setv({ start: ends[0], end: ends[1], reset_start: ends[0], reset_end: ends[1], tags: ends })
  }
}

// ---- moments ----
let momentRow = -1
let momentWaits = false // for an answer to the latest request
function mark(row) { // without a request
  momentRow = row
  by("moment").value = String(row)
  const at = shown.place[row]
  spans("moment", (span) => { span.location = at })
  const values = [`${shown.arrays.force0[row].toFixed(1)} and ${shown.arrays.force1[row].toFixed(1)} kN`]
  shown.nodes.forEach((name, node) => values.push(`${name} ${shown.arrays[`stress${node}`][row].toFixed(1)} MPa`))
  by("moment-words").textContent = `at ${at.toFixed(3)} m: ${values.join(", ")}`
}
function moveTo(row) {
  if (!shown || row === momentRow) return
  mark(Math.min(Math.max(row, 0), shown.place.length - 1))
  if (!momentWaits) requestAnimationFrame(() => { momentWaits = false; send({ number: shown.number, row: momentRow }) })
  momentWaits = true
}
by("moment").addEventListener("input", ({ target }) => moveTo(Number(target.value)))
for (const name of ["forces", "stresses"]) {
  by(name).addEventListener("pointermove", (event) => {
    const view = views[name]
    if (!view || event.buttons) return
    const x = view.frame.x_scale.invert(event.clientX - view.el.getBoundingClientRect().left)
    const { place } = shown ?? { place: [] }
    if (place.length > 1 && x >= place[0] && x <= place[place.length - 1]) moveTo(Math.round((x - place[0]) / (place[1] - place[0])))
  })
}
function drawMoment({ number, row, words, largest, image, middle, reach, arrays }) {
  if (!shown || number !== shown.number) return
  const { x, rail, wheel, touched } = arrays
  model("bodies").data = { x, rail, wheel, touched, top: new Float32Array(x.length).fill(1000), bottom: new Float32Array(x.length).fill(-1000) }
  frameBodies()
  const [columns, rows, left, bottom, dx, dy] = image
  model("pressure-map").data = {
    image: [ndarray(arrays.image, [rows, columns])], x: [left], y: [bottom], dw: [columns * dx], dh: [rows * dy],
  }
  model("pressure-colours").high = Math.max(1000, 500 * Math.ceil(largest / 500))
  const frame = views.pressure.frame.bbox
  const along = Math.max(reach[0], reach[1] * frame.width / frame.height) // one scale for both directions
  const across = along * frame.height / frame.width
  model("pressure-x").setv({ start: -along, end: along })
  model("pressure-y").setv({ start: middle - across, end: middle + across })
  by("pressure-words").textContent = words
  document.documentElement.dataset.moment = `${number}:${row}`
}
function ndarray(values, shape) {
  return Bokeh.require("core/util/ndarray").ndarray(values, { dtype: "float32", shape })
}
function frameBodies() { // heights are exaggerated by the factor that the page states, however wide it is
  const { width, height } = views.bodies.frame.bbox
  if (!(width > 0)) return
  const visible = 160 * height / width / settings.exaggerated
  model("bodies-y").setv({ start: -0.3 * visible, end: 0.7 * visible })
}
addEventListener("resize", () => requestAnimationFrame(frameBodies))

async function draw() {
  for (const [name, item] of Object.entries(JSON.parse(by("plots").textContent))) {
    const { roots: [view] } = await Bokeh.embed.embed_item(item)
    views[name] = view
    roots.push(view.model)
  }
  recolour()
  together()
  fit()
  document.documentElement.dataset.drawn = String(roots.length)
  connect()
}
draw()
