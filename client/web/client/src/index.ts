/* @collided/client: a client of collided-web: what is on the wire, what it adds up to, and whether it is proven. */
export * from "./protocol.js";
export * from "./world.js";
export { Checker, claimOf, prove, type Claim, type ClaimSide, type KernelAnswer, type Verdict } from "./checker.js";
export * from "./connection.js";
