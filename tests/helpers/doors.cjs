// Runs the solver's doors for another process: reads calls from standard input, and writes what they leave in buffers.
"use strict";
const fs = require("fs");
const solver = require(process.argv[2]);

function read(size) {
  const bytes = Buffer.alloc(size);
  for (let at = 0; at < size; ) {
    let got = 0;
    try {
      got = fs.readSync(0, bytes, at, size - at, null);
    } catch (error) {
      if (error.code === "EAGAIN") continue;
      throw error;
    }
    if (got === 0) process.exit(0);
    at += got;
  }
  return bytes;
}

function write(bytes) {
  for (let at = 0; at < bytes.length; ) {
    try {
      at += fs.writeSync(1, bytes, at);
    } catch (error) {
      if (error.code !== "EAGAIN") throw error;
    }
  }
}

for (;;) {
  const { door, values, sizes } = JSON.parse(read(read(4).readUInt32LE()).toString());
  const rooms = sizes.map((size) => new Float64Array(read(8 * size).buffer));
  const given = (value) => (Array.isArray(value) ? rooms[value[0]] : rooms[0][value]);
  const call = solver[door];
  const parts = values.map((value, i) =>
    call.takes[i] === null ? given(value) : Object.fromEntries(call.takes[i].map((name, j) => [name, given(value[j])])));
  const result = call(...parts);
  const number = Buffer.alloc(8);
  number.writeDoubleLE(result === undefined ? NaN : Number(result));
  write(Buffer.concat([number, ...rooms.slice(1).map((room) => Buffer.from(room.buffer))]));
}
