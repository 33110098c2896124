// Reads and writes a gauge with jsmodbus; prints what it saw as JSON.
const net = require("net");
const modbus = require("jsmodbus");

const socket = new net.Socket();
const client = new modbus.client.TCP(socket, 1);

socket.on("connect", async () => {
  const block = await client.readInputRegisters(0, 120);
  const coils = await client.readCoils(0, 8);
  await client.writeMultipleRegisters(200, [26550, 40, 30]);
  await client.writeSingleCoil(33, true);
  const written = await client.readHoldingRegisters(200, 3);
  const values = (answer) => Array.from(answer.response.body.valuesAsArray);
  console.log(JSON.stringify({
    words: values(block),
    coils: values(coils).slice(0, 8).map(Boolean),
    written: values(written),
  }));
  socket.end();
});
socket.connect({ host: "127.0.0.1", port: Number(process.argv[2]) });
