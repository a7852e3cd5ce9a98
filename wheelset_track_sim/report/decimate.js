// Fills `shown` with what `range` shows of `samples`: all entries, or the least and largest of each column of pixels.
// An entry is one step, or `size` steps from its least to its largest value.
const time = samples.data.time
const numbers = Object.keys(shown.data).filter((name) => name !== "time").map((name) => name.slice("value".length))
const [from, to] = [Math.min(range.start, range.end), Math.max(range.start, range.end)]

function entry(at) { // the first entry not before a time
  let [low, high] = [0, time.length]
  while (low < high) {
    const middle = (low + high) >> 1
    if (time[middle] < at) low = middle + 1
    else high = middle
  }
  return low
}

const [first, end] = [Math.max(0, entry(from) - 1), Math.min(time.length, entry(to) + 1)]
const pixels = Math.max(300, Math.round((plot.inner_width || 600) * (window.devicePixelRatio || 1)))
const columns = Math.min(pixels, end - first)
// Columns of equal time; with few entries each is a column of its own.
const borders = [first]
if (end - first <= 2 * pixels) for (let i = first + 1; i <= end; i++) borders.push(i)
else {
  for (let column = 1; column < columns; column++) {
    const border = Math.min(entry(from + ((to - from) * column) / columns), end)
    if (border > borders[borders.length - 1]) borders.push(border)
  }
  if (end > borders[borders.length - 1]) borders.push(end)
}

const data = { time: new Float64Array(2 * (borders.length - 1)) }
for (let i = 0; i + 1 < borders.length; i++) {
  const last = borders[i + 1] - 1
  const single = numbers.every((number) => samples.data["low" + number][last] === samples.data["high" + number][last])
  const reach = single || last + 1 === time.length ? 0 : (time[last + 1] - time[last]) * (1 - 1 / size)
  data.time[2 * i] = time[borders[i]]
  data.time[2 * i + 1] = time[last] + reach
}
for (const number of numbers) {
  const [low, high] = [samples.data["low" + number], samples.data["high" + number]]
  const values = new Float32Array(data.time.length)
  let before = low[first]
  for (let i = 0; i + 1 < borders.length; i++) {
    let [least, largest] = [Infinity, -Infinity]
    for (let at = borders[i]; at < borders[i + 1]; at++) {
      if (low[at] < least) least = low[at]
      if (high[at] > largest) largest = high[at]
    }
    if (least > largest) least = largest = NaN // all of it is missing
    const rising = before - least < largest - before // the nearer one first: a curve that only rises stays smooth
    values[2 * i] = rising ? least : largest
    values[2 * i + 1] = before = rising ? largest : least
  }
  data["value" + number] = values
}
shown.data = data
