/** The session: who shows the token of the printed address gets a secret, which goes with every question.
 * A cookie would go to the servers of all ports, also those of other users; what is stored here, pages of this port
 * alone can read. */

const KEY = "vibro-session";
const tokenOf = () => new URLSearchParams(location.hash.slice(1)).get("token");

export const isInvited = () => tokenOf() !== null;

/** @param {string} address @param {string | null} secret @param {AbortSignal} [signal] */
const send = (address, secret, signal) => fetch(address, { headers: { Authorization: `Bearer ${secret}` }, signal });

/** Ask as this session. @param {string} address @param {AbortSignal} [signal] */
export const ask = (address, signal) => send(address, localStorage.getItem(KEY), signal);

/** Exchange the token of the address for the secret; another window may have done so. */
export async function begin() {
  const response = await send("/session", tokenOf()).catch(() => null); // whether vibro is there is told later
  if (response?.ok) localStorage.setItem(KEY, await response.text());
  history.replaceState(null, "", "/");
}
