// The view as a link: what follows # in the address restores it.

/** Return the settings in an address's hash, an object of texts. */
export function parsed(hash) {
  const found = {};
  for (const part of hash.replace(/^#/, "").split("&")) {
    const at = part.indexOf("=");
    if (at <= 0) continue;
    try {
      found[part.slice(0, at)] = decodeURIComponent(part.slice(at + 1));
    } catch {
      // A link that was cut off: what is left of it still counts.
    }
  }
  return found;
}

/** Return settings as a hash; those that are empty are left out. */
export function written(settings) {
  const parts = Object.entries(settings).filter(([, value]) => value !== undefined && value !== null && value !== "");
  return `#${parts.map(([key, value]) => `${key}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&")}`;
}
