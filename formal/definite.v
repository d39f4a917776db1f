(* Positive definiteness by computation: u G = t L L' + R with u > 0 and t >= 0,
   where R is symmetric and its diagonal exceeds the sums of the sizes beside it. *)
From Coq Require Import ZArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Import integers.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

Definition below n (p : pred nat) := all p (iota 0 n).
Lemma belowP n (p : pred nat) : reflect (forall i, (i < n)%N -> p i) (below n p).
Proof.
apply: (iffP allP) => h i; first by move=> in_; apply: h; rewrite mem_iota.
by rewrite mem_iota => /andP[_]; rewrite add0n; exact: h.
Qed.

Definition remainder n (u t : Z) (L G : entries) : entries :=
  memo n n (fun i j => Z.sub (Z.mul u (G i j)) (Z.mul t (mul n L (tr L) i j))).
Definition beside (R : entries) i j :=
  if i == j then Z.opp (R i j) else Z.abs (R i j).
Definition dominant n (R : entries) : bool :=
  below n (fun i => below n (fun j => Z.eqb (R i j) (R j i)))
  && below n (fun i => Z.ltb (sumZ n (beside R i)) 0).
Definition definite n (u t : Z) (L G : entries) : bool :=
  [&& Z.ltb 0 u, Z.leb 0 t & dominant n (remainder n u t L G)].

Section Soundness.
Variable C : numClosedFieldType.
Implicit Types x : nat -> C.

(* The form x G x* of a row x. *)
Definition form n (g : nat -> nat -> C) x : C :=
  \sum_(i < n) \sum_(j < n) x i * g i j * (x j)^*.

Lemma square_form n (t : C) (L : nat -> nat -> C) x :
  0 <= t -> (forall i j, (L i j)^* = L i j) ->
  0 <= form n (fun i j => t * \sum_(k < n) L i k * L j k) x.
Proof.
move=> t0 real; have -> : form n (fun i j => t * \sum_(k < n) L i k * L j k) x
    = t * \sum_(k < n) `|\sum_(i < n) x i * L i k| ^+ 2.
  transitivity (\sum_(i < n) \sum_(j < n) \sum_(k < n)
      t * ((x i * L i k) * (x j * L j k)^*)).
    apply: eq_bigr => i _; apply: eq_bigr => j _.
    rewrite mulrA [x i * t]mulrC -!mulrA mulr_suml !mulr_sumr.
    apply: eq_bigr => k _; rewrite rmorphM real.
    by rewrite -!mulrA [(x j)^* * _]mulrC.
  transitivity (\sum_(i < n) \sum_(k < n) \sum_(j < n)
      t * ((x i * L i k) * (x j * L j k)^*)).
    by apply: eq_bigr => i _; exact: exchange_big.
  rewrite exchange_big mulr_sumr; apply: eq_bigr => k _.
  rewrite normCK rmorph_sum mulr_suml mulr_sumr; apply: eq_bigr => i _.
  by rewrite mulr_sumr mulr_sumr.
by rewrite mulr_ge0 // sumr_ge0 // => k _; rewrite exprn_ge0.
Qed.

Lemma conjD (a b : C) : (a + b)^* = a^* + b^*. Proof. exact: rmorphD. Qed.
Lemma conjN (a : C) : (- a)^* = - a^*. Proof. exact: rmorphN. Qed.

Lemma pair_bound (r : Z) (x y : C) :
  0 <= phi C r * (x * y^* + y * x^*) + phi C (Z.abs r) * (`|x| ^+ 2 + `|y| ^+ 2).
Proof.
rewrite !normCK; case: (Z.leb_spec 0 r) => r0.
  have /phi_ge0 h : Z.leb 0 r by lia.
  have -> : Z.abs r = r by lia.
  rewrite -mulrDr; apply: mulr_ge0; first exact: h.
  have -> : x * y^* + y * x^* + (x * x^* + y * y^*) = `|x + y| ^+ 2.
    by rewrite normCK conjD; ring.
  exact: exprn_ge0.
have /phi_ge0 h : Z.leb 0 (Z.opp r) by lia.
have -> : Z.abs r = Z.opp r by lia.
rewrite -[phi C r]opprK -phiN mulNr -mulrN -mulrDr; apply: mulr_ge0; first exact: h.
have -> : - (x * y^* + y * x^*) + (x * x^* + y * y^*) = `|x - y| ^+ 2.
  by rewrite normCK conjD conjN; ring.
exact: exprn_ge0.
Qed.

Theorem definite_sound n u t L G x : definite n u t L G ->
  (exists2 i, (i < n)%N & x i != 0) -> 0 < form n (fun i j => phi C (G i j)) x.
Proof.
rewrite /definite; set R := remainder n u t L G.
move=> /and4P[u0 t0 /belowP sym /belowP dom] [i0 lt0 nz0].
have symR i j : (i < n)%N -> (j < n)%N -> R i j = R j i.
  by move=> hi hj; apply/Z.eqb_eq; have /belowP := sym i hi; apply.
rewrite -(pmulr_rgt0 _ (phi_gt0 C u0)).
have -> : phi C u * form n (fun i j => phi C (G i j)) x
   = form n (fun i j => phi C t * \sum_(k < n) phi C (L i k) * phi C (L j k)) x
     + form n (fun i j => phi C (R i j)) x.
  rewrite /form mulr_sumr -big_split; apply: eq_bigr => i _.
  rewrite mulr_sumr -big_split; apply: eq_bigr => j _ /=.
  rewrite -mulrDl -mulrDr !mulrA [phi C u * _]mulrC -[_ * phi C u * _]mulrA.
  congr (_ * _ * _); rewrite /R /remainder memoE // phiB !phiM phi_sum addrC.
  rewrite (eq_bigr (fun k : 'I_n => phi C (L i k) * phi C (L j k))) ?subrK //.
  by move=> k _; exact: phiM.
apply: ltr_paddl.
  by apply: (@square_form n _ (fun i k => phi C (L i k))) => [|i j];
     [exact: phi_ge0 | exact: phi_conj].
set s := form _ _ _; pose d i := phi C (sumZ n (beside R i)).
have twice (f : 'I_n -> 'I_n -> C) :
    \sum_i \sum_j (f i j + f j i) = (\sum_i \sum_j f i j) *+ 2.
  by rewrite mulr2n [X in _ + X]exchange_big -big_split; apply: eq_bigr => i _;
     rewrite -big_split.
have less : \sum_(i < n) d i * `|x i| ^+ 2 < 0.
  rewrite (bigD1 (Ordinal lt0)) //=; apply: ltr_naddr.
    rewrite -oppr_ge0 -sumrN; apply: sumr_ge0 => i _; rewrite -mulNr.
    rewrite mulr_ge0 ?exprn_ge0 // oppr_ge0.
    by apply: ltW; apply: phi_lt0; exact: dom.
  by rewrite nmulr_rlt0 ?exprn_gt0 ?normr_gt0 //; apply: phi_lt0; exact: dom.
have : 0 <= s *+ 2 + (\sum_(i < n) d i * `|x i| ^+ 2) *+ 2.
  have -> : \sum_(i < n) d i * `|x i| ^+ 2
     = \sum_(i < n) \sum_(j < n) phi C (beside R i j) * `|x i| ^+ 2.
    by apply: eq_bigr => i _; rewrite /d phi_sum mulr_suml.
  rewrite /s /form -!twice -big_split; apply: sumr_ge0 => i _.
  rewrite -big_split; apply: sumr_ge0 => j _ /=.
  rewrite (symR j i) // /beside (symR j i) // [(_ == _ :> nat) in X in _ + X]eq_sym.
  have -> : x i * phi C (R i j) * (x j)^* + x j * phi C (R i j) * (x i)^*
     = phi C (R i j) * (x i * (x j)^* + x j * (x i)^*) by ring.
  rewrite -mulrDr; case: eqP => [->|_]; last exact: pair_bound.
  by rewrite phiN !normCK mulNr subrr.
rewrite -mulrnDl pmulrn_lge0 // => ge.
by rewrite -(ltr_add2r (\sum_(i < n) d i * `|x i| ^+ 2)) add0r (lt_le_trans less).
Qed.
End Soundness.
