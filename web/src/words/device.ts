// Texts of the page of a device.

export const missing = (name: string) => `${name} is not there.`;
export const all = "All devices";
export const noPoints = "This device has no points.";
export const address = (address: string) => `address ${address}`;
export const of = (network: string, owner: number) => `${network} of island ${owner}`;
export const since = "for";
export const pin = "Pin";
export const unpin = "Unpin";
export const tuples = "Tuples";
export const about = "Description and status";
export const ttlTitle = "A command that has to wait longer for its line or device expires, and is never executed.";
export const span = (seconds: number) => (seconds < 60 ? `${seconds} s` : seconds < 3600 ? `${seconds / 60} min` : `${seconds / 3600} h`);
export const kinds = { sensor: "Sensors", actuator: "Actuators", property: "Properties" };
export const points = (device: string) => `Points of ${device}`;
export const point = "Point";
export const value = "Value";
export const quality = "Quality";
export const heard = "Heard";
export const changed = "Changed";
export const hour = "Last hour";
export const control = "Set";
export const outcome = "Last command";
