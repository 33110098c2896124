// Reads and writes a gauge with modbus-serial; prints what it saw as JSON.
const ModbusRTU = require("modbus-serial");

async function main(port) {
  const client = new ModbusRTU();
  await client.connectTCP("127.0.0.1", { port });
  client.setID(1);
  // several requests in one segment, as this library sends them
  const [block, coils] = await Promise.all([client.readInputRegisters(0, 120), client.readCoils(0, 8)]);
  await client.writeRegisters(200, [26550, 40, 30]);
  await client.writeCoil(33, true);
  const written = await client.readHoldingRegisters(200, 3);
  console.log(JSON.stringify({ words: block.data, coils: coils.data.slice(0, 8), written: written.data }));
  client.close(() => {});
}

main(Number(process.argv[2]));
